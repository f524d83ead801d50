"""Patch table: the patch lists of all cells, one after the other."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.pipeline import Pipeline
from hw.memsys.patches.path_formats import PathFormats

__all__ = ["PatchTable"]


class PatchTable(wiring.Component):
    """Reads the patch lists that are in the cluster: the first ``own_entries`` of the scene.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_load : In, stream of `PathFormats.list_load`
        Entries in any order. Always ready; not while lists are in flight. Other addresses are ignored.
    patches : In(listed_bits)
        Patches of the scene. Stable while entries are loaded.
    i : In, stream of `PathFormats.list_extent`
        Lists.
    o : Out, stream of `PathFormats.listed`
        Their entries in order.

    Timing
    ------
    Latency: ``3`` cycles to the first entry; ``2`` of a load. One entry per cycle, without a gap between lists; stalls
    with ``o``.

    Golden counterpart: `golden.engine.memsys.patches.patch_table.PatchTable`. Source: Shen 1993, section 5.3.6.
    """

    def __init__(self, *, config: Config):
        self._formats = PathFormats(config)
        formats = self._formats
        super().__init__({
            "i_load": In(stream.Signature(formats.list_load, always_ready=True)),
            "patches": In(formats.scene["patches"].shape), "i": In(stream.Signature(formats.list_extent)),
            "o": Out(stream.Signature(formats.listed))})
        self._memory = Memory(shape=formats.listed_bits, depth=config.memsys.own_entries, init=[],
                              attrs={"no_rw_check": 1})
        self._entries = stream.Signature(StructLayout({"address": formats.entry_bits, "last": 1})).create()
        self._pipeline = pipeline = Pipeline(self._entries, self.o)
        address, last = (pipeline.input(self._entries.payload[name]) for name in ("address", "last"))
        pipeline.output(self.o.payload.number, pipeline.delay(pipeline.read(self._memory.read_port(), address), 1))
        pipeline.output(self.o.payload.last, last)
        self.latency = pipeline.latency + 1

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = self._memory
        self._pipeline.add_to(m)
        entries, busy, left = self._entries, Signal(), Signal(self._formats.entry_bits + 1, reset_less=True)
        address, last = Signal.like(entries.payload.address, reset_less=True), Signal(reset_less=True)
        m.d.comb += [entries.valid.eq(busy), entries.payload.address.eq(address), entries.payload.last.eq(last),
                     self.i.ready.eq(~busy | (entries.ready & last))]
        # Whether there is a list, or its last entry, decides alone what is loaded; the pipeline decides when.
        with m.If(~busy | entries.ready):
            with m.If(~busy | last):
                m.d.sync += [busy.eq(self.i.valid), address.eq(self.i.payload.pointer), left.eq(self.i.payload.count),
                             last.eq(self.i.payload.count == 1)]
            with m.Else():
                m.d.sync += [address.eq(address + 1), left.eq(left - 1), last.eq(left == 2)]

        given, write = self.i_load.payload, self._memory.write_port()
        no_patch = 1 << self._formats.listed_bits - 1
        m.d.sync += [
            write.en.eq(self.i_load.valid & (given.address[self._formats.entry_bits:] == 0)),
            write.addr.eq(given.address), write.data.eq(Mux(given.record < self.patches, given.record, no_patch))]
        return m
