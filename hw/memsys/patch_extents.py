"""Patch extents: the records of some patches, each by its id."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.memsys.image_layout import COUNT_BITS, PATCH_WORDS, RECORD_BYTES, RegionNumber
from hw.memsys.memory_formats import MemoryFormats

__all__ = ["PatchExtents"]

RECORD_BITS = RECORD_BYTES[RegionNumber.PATCHES.value].bit_length() - 1


class PatchExtents(wiring.Component):
    """``address = base + 64 id`` for each of some ids, in their order.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_id : In, stream of ``index``, ``id``
        Ids. Always ready; not while extents are given.
    i : In, stream of ``base``, ``count``
        The address of the records, and how many ids from index 0 on, at least 1. Accepted when the last extent of the
        previous ones has been taken.
    o : Out, stream of `MemoryFormats.read_extent`
        The words of a patch that are not padding.

    Timing
    ------
    Latency: ``2`` cycles. An extent every two cycles; stalls with ``o``.
    """

    latency = 2
    # Of an index: so many ids are read at once.
    index_bits = 4

    def __init__(self, *, config: Config):
        address = config.memory.address_bits
        super().__init__({
            "i_id": In(stream.Signature(StructLayout({"index": self.index_bits, "id": COUNT_BITS}),
                                        always_ready=True)),
            "i": In(stream.Signature(StructLayout({"base": address, "count": self.index_bits + 1}))),
            "o": Out(stream.Signature(MemoryFormats(config).read_extent))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.ids = ids = Memory(shape=COUNT_BITS, depth=1 << self.index_bits, init=[],
                                        attrs={"ram_style": "distributed"})
        write, read = ids.write_port(), ids.read_port(domain="comb")
        given, index = Signal.like(self.i.payload, reset_less=True), Signal.like(self.i.payload.count)
        busy = Signal()
        m.d.comb += [
            write.addr.eq(self.i_id.payload.index), write.data.eq(self.i_id.payload.id), write.en.eq(self.i_id.valid),
            read.addr.eq(index), self.i.ready.eq(~busy), self.o.payload.length.eq(PATCH_WORDS - 1)]
        with m.If(self.i.ready):
            m.d.sync += [given.eq(self.i.payload), index.eq(0), busy.eq(self.i.valid)]
        with m.Elif(~self.o.valid):
            m.d.sync += [self.o.valid.eq(1), self.o.payload.address.eq(given.base + (read.data << RECORD_BITS)),
                         index.eq(index + 1)]
        with m.Elif(self.o.ready):
            m.d.sync += [self.o.valid.eq(0), busy.eq(index != given["count"])]
        return m
