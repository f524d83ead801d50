"""Patch extents: the records of some patches, each by its id."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.pipeline import Pipeline
from hw.memsys.load.image_layout import COUNT_BITS, PATCH_WORDS, RECORD_BYTES, RegionNumber
from hw.memsys.port.memory_formats import MemoryFormats

__all__ = ["PatchExtents"]

RECORD_BITS = RECORD_BYTES[RegionNumber.PATCHES.value].bit_length() - 1


class PatchExtents(wiring.Component):
    """``address = base + 64 id`` for each of some ids, in their order.

    The ids are in a block RAM: as many as its narrowest form for a whole id has.

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
    Latency: ``4`` cycles. One extent per cycle; stalls with ``o``.
    """

    # Of an index: so many ids are read at once.
    index_bits = 9

    def __init__(self, *, config: Config):
        address = config.memory.address_bits
        super().__init__({
            "i_id": In(stream.Signature(StructLayout({"index": self.index_bits, "id": COUNT_BITS}),
                                        always_ready=True)),
            "i": In(stream.Signature(StructLayout({"base": address, "count": self.index_bits + 1}))),
            "o": Out(stream.Signature(MemoryFormats(config).read_extent))})
        self._ids = Memory(shape=COUNT_BITS, depth=1 << self.index_bits, init=[], attrs={"no_rw_check": 1})
        self._base = Signal(address, reset_less=True)
        self._step = stream.Signature(StructLayout({"index": self.index_bits, "last": 1})).create()
        self._last = Signal()
        self._pipeline = pipeline = Pipeline(self._step, self.o)
        index, last = (pipeline.input(self._step.payload[name]) for name in ("index", "last"))
        number = pipeline.delay(pipeline.read(self._ids.read_port(), index), 1)
        pipeline.output(self.o.payload.address, pipeline.register(
            lambda number, base: base + (number << RECORD_BITS), number, pipeline.constant(self._base)))
        pipeline.output(self._last, last)
        self.latency = 1 + pipeline.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.ids = self._ids
        write, step = self._ids.write_port(), self._step
        index, final, busy = step.payload.index, Signal(self.index_bits, reset_less=True), Signal()
        m.d.comb += [
            write.addr.eq(self.i_id.payload.index), write.data.eq(self.i_id.payload.id), write.en.eq(self.i_id.valid),
            step.payload.last.eq(index == final), self.i.ready.eq(~busy), self.o.payload.length.eq(PATCH_WORDS - 1)]
        with m.If(self.i.ready):
            m.d.sync += [self._base.eq(self.i.payload.base), final.eq(self.i.payload["count"] - 1), index.eq(0),
                         step.valid.eq(self.i.valid), busy.eq(self.i.valid)]
        with m.Else():
            with m.If(step.valid & step.ready):
                m.d.sync += [index.eq(index + 1), step.valid.eq(~step.payload.last)]
            with m.If(self.o.valid & self.o.ready):
                m.d.sync += busy.eq(~self._last)
        self._pipeline.add_to(m)
        return m
