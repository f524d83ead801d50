"""Read-out: the hits of a finished frustum's section, in the order of its rays."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.formats import Formats
from hw.lib.queue import Queue

__all__ = ["ReadOut"]


class ReadOut(wiring.Component):
    """Asks the ray memory for one ray after the other, row by row of the section.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i
        ``bank`` to read, ``section`` and ``tiles_across`` of its frustum.
    o_ask
        ``bank`` and ``ray``, to `RayMemory.i_read`.
    i_hit
        `Formats.hit`, the answers in order.
    o
        ``column`` and ``row`` of the frustum, ``hit``, ``last`` of the section.
    busy, bank
        A read-out is under way, and of which bank.

    Timing
    ------
    Latency: ``8`` cycles to the first hit, of which 7 are the ray memory's. One ray per cycle; stalls with ``o``.

    Golden counterpart: `golden.cast.fixed_hits.read_out`.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, Formats(config)
        formats = self._formats
        self._place = StructLayout({"column": formats.index, "row": formats.index, "last": 1})
        super().__init__({
            "i": In(stream.Signature(StructLayout({"bank": 1, "section": formats.section,
                                                   "tiles_across": formats.count}))),
            "o_ask": Out(stream.Signature(StructLayout({"bank": 1, "ray": formats.ray}))),
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
        asks = Signal()
        # The places of the rays that have been asked for.
        m.submodules.places = places = Queue(self._place, depth=16)
        section = command.section
        end_column, end_row = (Signal(self._formats.index) for _ in range(2))
        last_column, last_row = column == end_column, row == end_row
        m.d.comb += [
            self.i.ready.eq(~self.busy), self.bank.eq(command.bank),
            self.o_ask.valid.eq(asks & places.i.ready), places.i.valid.eq(asks & self.o_ask.ready),
            self.o_ask.payload.bank.eq(command.bank),
            self.o_ask.payload.ray.eq(Cat(column[:side], row[:side], (base + (column >> side))[:len(base)])),
            places.i.payload.column.eq(column + section.first_column),
            places.i.payload.row.eq(row + section.first_row), places.i.payload.last.eq(last_column & last_row),
            self.o.valid.eq(self.i_hit.valid & places.o.valid), self.i_hit.ready.eq(self.o.ready & places.o.valid),
            places.o.ready.eq(self.o.ready & self.i_hit.valid),
            self.o.payload.column.eq(places.o.payload.column), self.o.payload.row.eq(places.o.payload.row),
            self.o.payload.last.eq(places.o.payload.last), self.o.payload.hit.eq(self.i_hit.payload)]
        with m.If(self.i.valid & self.i.ready):
            given = self.i.payload.section
            m.d.sync += [command.eq(self.i.payload), self.busy.eq(1), asks.eq(1), column.eq(0), row.eq(0), base.eq(0),
                         end_column.eq(given.end_column - given.first_column - 1),
                         end_row.eq(given.end_row - given.first_row - 1)]
        with m.If(asks & self.o_ask.ready & places.i.ready):
            m.d.sync += column.eq(Mux(last_column, 0, column + 1))
            with m.If(last_column):
                m.d.sync += row.eq(row + 1)
                with m.If(row[:side].all()):
                    m.d.sync += base.eq(base + command.tiles_across)
                with m.If(last_row):
                    m.d.sync += asks.eq(0)
        with m.If(self.o.valid & self.o.ready & self.o.payload.last):
            m.d.sync += self.busy.eq(0)
        return m
