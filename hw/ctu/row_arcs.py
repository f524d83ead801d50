"""Row arcs: which columns of grid rays belong to the sector, row by row."""

from amaranth.hdl import Module, Mux
from amaranth.lib import stream, wiring
from amaranth.lib.data import View
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.ctu.grid_rays import INDEX_FRACTION
from hw.ctu.ctu_formats import CtuFormats, GridTableKind
from hw.lib.pipeline import Pipeline
from hw.lib.skid_buffer import SkidBuffer

__all__ = ["RowArcs"]


class RowArcs(wiring.Component):
    """Positions from the sector's first column less ``column_border`` to its end and as much more; around a hemisphere
    modulo its columns, and all of them if they are as many.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of addresses
        A row of the table.
    i_table : In, stream of `CtuFormats.grid_table_write`
        Table entries, of which the borders of ROW are used. Always ready; not while rows are in flight.
    o : Out, stream of `CtuFormats.arcs`
        The sector's columns in this row.
    frustum : In, `Formats.frustum`
        Constant while rows are in flight.

    Timing
    ------
    Latency: ``7`` cycles. One row per cycle; stalls while the row at the end waits, and a register enables all others.

    Golden counterpart: `golden.engine.ctu.sector.sector_rays`.
    """

    def __init__(self, *, config: Config):
        formats = CtuFormats(config)
        super().__init__({
            "i": In(stream.Signature(formats.grid_row_address)),
            "i_table": In(stream.Signature(formats.grid_table_write, always_ready=True)),
            "o": Out(stream.Signature(formats.arcs)), "frustum": In(formats.frustum)})
        self._row = formats.grid_row
        self._borders = Memory(shape=formats.reach, depth=1 << formats.grid_row_address.width, init=[])
        self._skid = SkidBuffer(self.o.payload.shape())
        self._pipeline = pipeline = Pipeline(self.i, self._skid.i, ready_next=self._skid.ready_next)
        bound, section = formats.position_bound, self.frustum.section
        lowest, highest = -(1 << bound.width - 1), (1 << bound.width - 1) - 1
        around = self.frustum.columns << INDEX_FRACTION
        border = pipeline.delay(pipeline.read(self._borders.read_port(), pipeline.input(self.i.payload)), 1)
        low = pipeline.register(lambda border: (section.first_column << INDEX_FRACTION) - border, border)
        end = pipeline.register(lambda border: (section.end_column << INDEX_FRACTION) + border + 1, border)
        over = pipeline.register(lambda end: end - around, end)
        up = pipeline.register(lambda low: low + around, low)
        # More than once around: from ``low`` on the whole circle lies before ``end``.
        whole = pipeline.register(lambda up, end: ~self.frustum.is_screen & (end >= up), up, end)
        begins_before, goes_over = (pipeline.register(lambda value, is_upper=is_upper: ~self.frustum.is_screen & (
            value > 0 if is_upper else value < 0), value) for value, is_upper in ((low, False), (over, True)))
        wraps = pipeline.register(lambda whole, before, over: ~whole & (before | over),
                                  whole, begins_before, goes_over)
        arcs = self._skid.i.payload
        pipeline.output(arcs.wraps, wraps)
        pipeline.output(arcs.low, pipeline.register(
            lambda whole, before, low, up: Mux(whole, lowest, Mux(before, up, low)), whole, begins_before, low, up))
        pipeline.output(arcs.end, pipeline.register(
            lambda whole, before, over, end: Mux(whole | before | over, highest, end),
            whole, begins_before, goes_over, end))
        pipeline.output(arcs.over, pipeline.register(
            lambda before, end, over: Mux(before, end, over), begins_before, end, over))
        self.latency = pipeline.latency + self._skid.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.borders = self._borders
        port, table = self._borders.write_port(), self.i_table
        m.d.comb += [port.addr.eq(table.payload.index),
                     port.data.eq(View(self._row, table.payload.data[:self._row.size]).column_border),
                     port.en.eq(table.valid & (table.payload.kind == GridTableKind.ROW))]
        self._pipeline.add_to(m)
        m.submodules.skid = self._skid
        wiring.connect(m, self._skid.o, wiring.flipped(self.o))
        return m
