"""Read-out: the hits of a finished frustum's section, in the order of its rays."""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.lib.queue import Queue
from hw.lib.skid_buffer import SkidBuffer

__all__ = ["ReadOut"]


class ReadOut(wiring.Component):
    """Reads one ray after the other from the ray memory, row by row of the section.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of ``bank``, ``section``, ``tiles_across``
        The bank to read, and what its frustum was.
    o_read : Out, stream of ``bank``, ``ray``
        To `RayMemory.i_read`.
    i_hit : In, stream of `IcuFormats.hit`
        The replies, in order.
    o : Out, stream of ``column``, ``row``, ``hit``, ``last``
        The rays of the section; column and row are those of the frustum.
    busy : Out(1)
        A read-out is in progress.
    bank : Out(1)
        The bank that it reads.

    Timing
    ------
    Latency: ``9`` cycles to the first hit, of which 7 are the ray memory's. One ray per cycle; stalls with ``o``.

    Golden counterpart: `golden.engine.cast.fixed_hits.read_out`.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, IcuFormats(config)
        formats = self._formats
        self._position = StructLayout({"column": formats.index, "row": formats.index, "last": 1})
        super().__init__({
            "i": In(stream.Signature(StructLayout({"bank": 1, "section": formats.section,
                                                   "tiles_across": formats.count}))),
            "o_read": Out(stream.Signature(StructLayout({"bank": 1, "ray": formats.ray}))),
            "i_hit": In(stream.Signature(formats.hit)),
            "o": Out(stream.Signature(StructLayout({"column": formats.index, "row": formats.index,
                                                    "hit": formats.hit, "last": 1}))),
            "busy": Out(1), "bank": Out(1)})

    def elaborate(self, platform):
        m = Module()
        side = self._config.icu.tile_bits
        command = Signal.like(self.i.payload)
        column, row = (Signal(self._formats.index) for _ in range(2))
        # Of the row of tiles: the number of its first one.
        base = Signal(self._formats.tile)
        reads = Signal()
        # Column and row of the outstanding reads.
        m.submodules.positions = positions = Queue(self._position, depth=16)
        section = command.section
        before_end, end_row = (Signal(self._formats.index) for _ in range(2))
        last_column, single, last_row = Signal(), Signal(), row == end_row
        # Registers in both directions: no combinational path joins the ray memory and the sink of hits.
        m.submodules.found = found = SkidBuffer(self.o.payload.shape())
        wiring.connect(m, found.o, wiring.flipped(self.o))
        m.d.comb += [
            self.i.ready.eq(~self.busy), self.bank.eq(command.bank),
            self.o_read.valid.eq(reads & positions.i.ready), positions.i.valid.eq(reads & self.o_read.ready),
            self.o_read.payload.bank.eq(command.bank),
            self.o_read.payload.ray.eq(Cat(column[:side], row[:side], (base + (column >> side))[:len(base)])),
            positions.i.payload.column.eq(column + section.first_column),
            positions.i.payload.row.eq(row + section.first_row), positions.i.payload.last.eq(last_column & last_row),
            found.i.valid.eq(self.i_hit.valid & positions.o.valid),
            self.i_hit.ready.eq(found.i.ready & positions.o.valid),
            positions.o.ready.eq(found.i.ready & self.i_hit.valid),
            found.i.payload.column.eq(positions.o.payload.column), found.i.payload.row.eq(positions.o.payload.row),
            found.i.payload.last.eq(positions.o.payload.last), found.i.payload.hit.eq(self.i_hit.payload)]
        with m.If(self.i.valid & self.i.ready):
            given = self.i.payload.section
            columns = given.end_column - given.first_column
            m.d.sync += [command.eq(self.i.payload), self.busy.eq(1), reads.eq(1), column.eq(0), row.eq(0), base.eq(0),
                         before_end.eq(columns - 2), last_column.eq(columns == 1), single.eq(columns == 1),
                         end_row.eq(given.end_row - given.first_row - 1)]
        with m.If(reads & self.o_read.ready & positions.i.ready):
            m.d.sync += [column.eq(column + 1), last_column.eq(column == before_end)]
            with m.If(last_column):
                m.d.sync += [column.eq(0), row.eq(row + 1), last_column.eq(single)]
                with m.If(row[:side].all()):
                    m.d.sync += base.eq(base + command.tiles_across)
                with m.If(last_row):
                    m.d.sync += reads.eq(0)
        with m.If(self.o.valid & self.o.ready & self.o.payload.last):
            m.d.sync += self.busy.eq(0)
        return m
