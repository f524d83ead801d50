"""Near window: the rays that a grid ray, or neighbours in a row, stand for."""

from amaranth.hdl import Module, Mux
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout, View
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.ctu.grid_rays import INDEX_FRACTION
from hw.ctu.ctu_formats import CtuFormats, GridTableKind
from hw.lib.pipeline import Pipeline
from hw.lib.shared_port import share_port

__all__ = ["NearWindow"]

HALF = 1 << INDEX_FRACTION - 1


class NearWindow(wiring.Component):
    """``first = -((reach + 1/2 - position) >> 8)`` and ``last = (position + reach - 1/2) >> 8`` of the columns; the
    rows are its row's.

    Of a screen the columns are clipped, of a hemisphere they go round, and all of them begin with column 0. Of
    neighbours the first one's ``first`` and the last one's ``last`` are taken: all that is near any of them lies there.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of the sideband.

    Members
    -------
    i_table : In, stream of `CtuFormats.grid_table_write`
        Table entries. Always ready.
    i : In, stream of ``tag``, ``shell``, ``row``, ``column``, ``last``
        Addresses of the first and of the last of neighbours, or twice the same column. Always ready.
    o : Out, stream of ``tag``, ``threshold``, ``window``
        The shell's threshold, and the near rays (`Formats.window`). Always ready.
    is_screen : In(1)
    columns : In(count)
        The frustum's; constant while rays are in flight.

    Timing
    ------
    Latency: ``7`` cycles. One window per cycle; nothing stalls.

    Golden counterpart: `golden.engine.ctu.grid_rays.GridRays`, ``first_row`` to ``column_count``.
    """

    def __init__(self, *, config: Config, tag):
        formats = CtuFormats(config)
        super().__init__({
            "i_table": In(stream.Signature(formats.grid_table_write, always_ready=True)),
            "i": In(stream.Signature(StructLayout({
                "tag": tag, "shell": formats.shell, "row": formats.grid_row_address,
                "column": formats.grid_column_address, "last": formats.grid_column_address}), always_ready=True)),
            "o": Out(stream.Signature(StructLayout({"tag": tag, "threshold": formats.threshold,
                                                    "window": formats.window}), always_ready=True)),
            "is_screen": In(1), "columns": In(formats.count)})
        self._pipeline = pipeline = Pipeline(self.i, self.o)
        self._tables, rows = [], StructLayout({name: formats.grid_row[name].shape
                                               for name in ("first_near", "near", "column_reach")})

        def entry(kind, record, kept, index):
            """What is kept of a table's record."""
            memory = Memory(shape=kept, depth=1 << len(index), init=[])
            self._tables.append((memory, kind, record))
            return pipeline.delay(pipeline.read(memory.read_port(), pipeline.input(index)), 1)

        given, window, columns = self.i.payload, self.o.payload.window, pipeline.constant(self.columns)
        threshold = entry(GridTableKind.SHELL, formats.grid_shell, StructLayout({"threshold": formats.threshold}),
                          given.shell)
        row = entry(GridTableKind.ROW, formats.grid_row, rows, given.row)
        # Both positions at once; what is written goes through the last one's port.
        self._record, self._positions = formats.grid_column, Memory(
            shape=formats.position, depth=1 << len(given.column), init=[], attrs={"no_rw_check": 1})
        ports = self._positions.read_port(), self._positions.read_port()
        self._shared = ports[1]
        left, right = (pipeline.delay(pipeline.read(port, pipeline.input(index)), 1)
                       for port, index in zip(ports, (given.column, given.last), strict=True))

        def step(function, *operands):
            return pipeline.register(function, *operands)

        low, high = step(lambda row, left, right: (left - row.column_reach, right + row.column_reach), row, left, right)
        first = step(lambda low: (low + (HALF - 1)) >> INDEX_FRACTION, low)
        last = step(lambda high: (high - HALF) >> INDEX_FRACTION, high)
        first = step(lambda first: Mux(self.is_screen & (first < 0), 0, first), first)
        last = step(lambda last, columns: Mux(self.is_screen & (last >= columns), columns - 1, last), last, columns)
        span = step(lambda first, last: last - first + 1, first, last)
        every = pipeline.combine(lambda span, columns: span >= columns, span, columns)
        pipeline.output(window.column_count, step(
            lambda span, every, columns: Mux(span < 0, 0, Mux(every, columns, span)), span, every, columns))
        # A hemisphere has a power of two of columns.
        pipeline.output(window.column_first, step(
            lambda first, every, columns: Mux(every, 0, Mux(self.is_screen, first, first & (columns - 1))),
            first, every, columns))
        pipeline.output(window.row_first, pipeline.combine(lambda row: row.first_near, row))
        pipeline.output(window.row_count, pipeline.combine(lambda row: row.near, row))
        pipeline.output(self.o.payload.threshold, pipeline.combine(lambda entry: entry.threshold, threshold))
        pipeline.output(self.o.payload.tag, pipeline.input(given.tag))
        self.latency = pipeline.latency

    def elaborate(self, platform):
        m = Module()
        add_tables(m, self.i_table, self._tables)
        self._pipeline.add_to(m)
        m.submodules.positions, write = self._positions, self.i_table.payload
        share_port(self._shared, m, self._positions.write_port(),
                          enable=self.i_table.valid & (write.kind == GridTableKind.COLUMN), address=write.index,
                          data=View(self._record, write.data[:self._record.size]).position)
        return m


def add_tables(m, i_table, tables):
    """Memories that keep a part of the records of their kind: of each the memory, the kind and the record."""
    write = i_table.payload
    for memory, kind, record in tables:
        m.submodules[f"table_{kind.name.lower()}"] = memory
        port = memory.write_port()
        given = View(record, write.data[:record.size])
        m.d.comb += [port.en.eq(i_table.valid & (write.kind == kind)), port.addr.eq(write.index),
                     *(port.data[name].eq(given[name]) for name, _ in memory.shape)]
