"""Patch queue: vertices wait for a slot, then enter patch setup."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.lib.checks import count_entries, count_up_down
from hw.lib.queue import Queue

__all__ = ["PatchQueue"]


class PatchQueue(wiring.Component):
    """Gives each patch a slot and each of its vertices an index.

    Slots are allocated in turn and freed in the same order, so a counter allocates them. The first vertex of a
    patch waits until a slot is free; the other three always follow.

    Parameters
    ----------
    config
        The configuration.
    depth
        Capacity of the queue in vertices.

    Members
    -------
    i : In, stream of `Formats.patch_vertex`
        The four vertices of a patch follow each other.
    o : Out, stream of ``slot``, ``index``, ``item``, always ready
        Vertices with their slot and an index from 0 to 3.
    free : In(1)
        The slot that was allocated first is free again.
    waiting : Out(range(slots + 1))
        Patches that have a slot.

    Timing
    ------
    Latency: that of `Queue`, if a slot is free. One vertex per cycle; stalls while ``icu.slots`` patches have a slot.
    """

    def __init__(self, *, config: Config, depth: int = 8):
        formats = IcuFormats(config)
        self._slots = config.icu.slots
        super().__init__({
            "i": In(stream.Signature(formats.patch_vertex)),
            "o": Out(stream.Signature(StructLayout({"slot": formats.slot, "index": 2, "item": formats.patch_vertex}),
                                      always_ready=True)),
            "free": In(1),
            "waiting": Out(range(self._slots + 1)),
        })
        self._queue = Queue(formats.patch_vertex, depth=depth)
        self.latency = self._queue.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.queue = queue = self._queue
        wiring.connect(m, wiring.flipped(self.i), queue.i)
        slot, index = Signal.like(self.o.payload.slot), Signal(2)
        enters, takes = Signal(), Signal()
        # A register, known a step ahead: all slots are taken.
        is_full = Signal()
        m.d.sync += is_full.eq(~self.free & (is_full | (takes & (self.waiting == self._slots - 1))))
        m.d.comb += [
            enters.eq(queue.o.valid & ((index != 0) | ~is_full)),
            takes.eq(enters & (index == 0)),
            queue.o.ready.eq(enters), self.o.valid.eq(enters),
            self.o.payload.slot.eq(slot), self.o.payload.index.eq(index), self.o.payload.item.eq(queue.o.payload),
        ]
        with m.If(enters):
            m.d.sync += index.eq(index + 1)
            with m.If(index == 3):
                m.d.sync += slot.eq(slot + 1)
        count_entries(self.waiting)
        count_up_down(m, self.waiting, up=takes, down=self.free, most=self._slots)
        return m
