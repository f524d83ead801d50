"""Grid entries: what the tables say of a grid ray that leaves."""

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.ctu.ctu_formats import CtuFormats, GridTableKind
from hw.ctu.near_window import add_tables
from hw.lib.pipeline import Pipeline
from hw.lib.skid_buffer import SkidBuffer

__all__ = ["GridEntries"]


class GridEntries(wiring.Component):
    """The segment of a grid ray's shell, and the entries of its column and row.

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
    i : In, stream of ``tag``, ``shell``, ``row``, ``column``
        A grid ray: addresses of the tables.
    o : Out, stream of ``tag``, ``begin``, ``length``, ``column``, ``row``
        The segment of its shell, and its entries (`CtuFormats.grid_pair`).

    Timing
    ------
    Latency: ``3`` cycles. One ray per cycle; stalls while the ray at the end waits, and a register enables all others.

    Golden counterpart: `golden.engine.memory_map`, ``shells``, ``grid_rows`` and ``grid_columns``.
    """

    def __init__(self, *, config: Config, tag):
        formats = CtuFormats(config)
        segment = StructLayout({"begin": formats.begin, "length": formats.parameter})
        pair = StructLayout({"table": formats.grid_pair})
        super().__init__({
            "i_table": In(stream.Signature(formats.grid_table_write, always_ready=True)),
            "i": In(stream.Signature(StructLayout({
                "tag": tag, "shell": formats.shell, "row": formats.grid_row_address,
                "column": formats.grid_column_address}))),
            "o": Out(stream.Signature(StructLayout({
                "tag": tag, **segment.members, "column": formats.grid_pair, "row": formats.grid_pair})))})
        self._skid = SkidBuffer(self.o.payload.shape())
        self._pipeline = pipeline = Pipeline(self.i, self._skid.i, ready_next=self._skid.ready_next)
        given, made, self._tables = self.i.payload, self._skid.i.payload, []
        for kind, record, kept, address, outputs in (
                (GridTableKind.SHELL, formats.grid_shell, segment, given.shell,
                 {"begin": made.begin, "length": made.length}),
                (GridTableKind.ROW, formats.grid_row, pair, given.row, {"table": made.row}),
                (GridTableKind.COLUMN, formats.grid_column, pair, given.column, {"table": made.column})):
            memory = Memory(shape=kept, depth=1 << len(address), init=[])
            self._tables.append((memory, kind, record))
            entry = pipeline.delay(pipeline.read(memory.read_port(), pipeline.input(address)), 1)
            for name, target in outputs.items():
                pipeline.output(target, pipeline.combine(lambda entry, name=name: entry[name], entry))
        pipeline.output(made.tag, pipeline.input(given.tag))
        self.latency = pipeline.latency + self._skid.latency

    def elaborate(self, platform):
        m = Module()
        add_tables(m, self.i_table, self._tables)
        self._pipeline.add_to(m)
        m.submodules.skid = self._skid
        wiring.connect(m, self._skid.o, wiring.flipped(self.o))
        return m
