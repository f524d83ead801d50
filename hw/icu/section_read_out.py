"""Section read-out: the hits of a section, or the bits of a shadow frustum's list."""

from amaranth.hdl import Module, Mux
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.icu.list_read_out import ListReadOut
from hw.icu.read_out import ReadOut

__all__ = ["SectionReadOut"]


class SectionReadOut(wiring.Component):
    """`ReadOut` or `ListReadOut`, as the frustum has it.

    Parameters
    ----------
    config
        The configuration, with ``icu.shadow_bits``.

    Members
    -------
    i : In, stream of ``bank``, ``section``, ``tiles_across``, ``is_list``
        `ReadOut`'s; with ``is_list`` its ``bank`` is for `ListReadOut`.
    i_ray : In, stream of ``bank``, ``ray``, ``is_ray``, ``last``, always ready
        `ListReadOut`'s.
    o_read : Out, stream of ``bank``, ``ray``
        The one's that reads, like the next three.
    i_hit : In, stream of `IcuFormats.hit`
        The replies, in order.
    busy : Out(1)
        A read-out is in progress.
    bank : Out(1)
        The bank that it reads.
    o : Out, stream of `IcuFormats.read_ray`
        The rays of the section, or the words of the list in the columns of one row.

    Timing
    ------
    See `ReadOut` and `ListReadOut`.
    """

    def __init__(self, *, config: Config):
        self._grid, self._list = ReadOut(config=config), ListReadOut(config=config)
        grid, listed = self._grid.signature.members, self._list.signature.members
        command = self._grid.i.payload.shape().members
        super().__init__({
            "i": In(stream.Signature(StructLayout({**command, "is_list": 1}))), "i_ray": listed["i_ray"],
            "o_read": grid["o_read"], "i_hit": grid["i_hit"],
            "o": Out(stream.Signature(IcuFormats(config).read_ray)), "busy": Out(1), "bank": Out(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.grid, m.submodules.list = grid, listed = self._grid, self._list
        wiring.connect(m, wiring.flipped(self.i_ray), listed.i_ray)
        given, units = self.i.payload, (grid, listed)
        m.d.comb += [
            self.busy.eq(grid.busy | listed.busy), self.bank.eq(Mux(listed.busy, listed.bank, grid.bank)),
            self.i.ready.eq(~self.busy), grid.i.valid.eq(self.i.valid & ~self.busy & ~given.is_list),
            listed.i.valid.eq(self.i.valid & ~self.busy & given.is_list),
            *(grid.i.payload[name].eq(given[name]) for name in grid.i.payload.shape().members),
            listed.i.payload.bank.eq(given.bank)]
        # One of them is busy at a time.
        m.d.comb += [
            self.o_read.valid.eq(grid.o_read.valid | listed.o_read.valid), self.o_read.payload.bank.eq(self.bank),
            self.o_read.payload.ray.eq(Mux(listed.busy, listed.o_read.payload.ray, grid.o_read.payload.ray)),
            self.i_hit.ready.eq(Mux(listed.busy, listed.i_hit.ready, grid.i_hit.ready)),
            self.o.valid.eq(grid.o.valid | listed.o.valid)]
        for unit in units:
            m.d.comb += [unit.o_read.ready.eq(self.o_read.ready), unit.o.ready.eq(self.o.ready),
                         unit.i_hit.valid.eq(self.i_hit.valid), unit.i_hit.payload.eq(self.i_hit.payload)]
        found, word = self.o.payload, listed.o.payload
        m.d.comb += [found[name].eq(grid.o.payload[name]) for name in grid.o.payload.shape().members]
        m.d.comb += [found.is_word.eq(listed.busy), found.word.eq(word.word)]
        with m.If(listed.busy):
            m.d.comb += [found.column.eq(word.index), found.row.eq(0), found.hit.eq(0), found.last.eq(word.last)]
        return m
