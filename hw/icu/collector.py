"""Collector: per-patch sums of the rays' form-factor weights."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.icu.icu_formats import WEIGHT_BITS, IcuFormats, TableKind
from hw.lib.queue import Queue
from hw.lib.update_memory import UpdateMemory

__all__ = ["Collector"]


class Collector(wiring.Component):
    """Adds the weight of each ray that hit a patch to the patch's sum; sums accumulate over frusta until they are read.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of ``row``, ``hit``
        Row of the frustum and `IcuFormats.hit` of a ray. Stalls while sums are being read.
    i_table : In, stream of `IcuFormats.table_write`, always ready
        Entries of WEIGHT are stored. The sender must not write a row in the cycle in which a hit of it arrives.
    i_read : In, stream of a number of patches
        Reads the sums of so many patches, from patch 0 on, and clears them.
    o : Out, stream of `IcuFormats.patch_sum`
        The sums.
    busy : Out(1)
        Sums are being read, or cleared after reset.

    Timing
    ------
    Latency: ``6`` cycles to the first sum. One hit per cycle, one sum per cycle; 2^``patch_bits`` cycles to clear all
    sums after reset.

    Golden counterpart: `golden.icu.collector.collect`.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, IcuFormats(config)
        formats = self._formats
        super().__init__({
            "i": In(stream.Signature(StructLayout({"row": formats.index, "hit": formats.hit}))),
            "i_table": In(stream.Signature(formats.table_write, always_ready=True)),
            "i_read": In(stream.Signature(config.icu.patch_bits + 1)),
            "o": Out(stream.Signature(formats.patch_sum)),
            "busy": Out(1)})

    def elaborate(self, platform):
        m = Module()
        formats, icu = self._formats, self._config.icu
        operand = StructLayout({"weight": WEIGHT_BITS, "hit": 1, "clear": 1})

        width = formats.weight_sum.width

        def change(old, operand):
            # The bit above the sum is set by the first carry and stays.
            total = old[:width] + operand.weight
            return (Mux(operand.clear, 0, Cat(total[:width], old[width] | total[width])),
                    operand.clear | operand.hit)

        m.submodules.sums = sums = UpdateMemory(
            width + 1, depth=1 << icu.patch_bits, operand=operand,
            tag=StructLayout({"reads": 1, "last": 1}), change=change)
        m.submodules.weights = weights = Memory(shape=WEIGHT_BITS, depth=1 << icu.side_bits, init=[],
                                                attrs={"no_rw_check": 1})
        write, read = weights.write_port(), weights.read_port(domain="comb")
        given = self.i_table
        m.d.comb += [write.addr.eq(given.payload.index), write.data.eq(given.payload.data),
                     write.en.eq(given.valid & (given.payload.kind == TableKind.WEIGHT)),
                     read.addr.eq(self.i.payload.row)]

        capacity = 8
        m.submodules.queue = queue = Queue(self.o.payload.shape(), depth=capacity)
        wiring.connect(m, queue.o, wiring.flipped(self.o))
        outstanding = Signal(range(capacity + 1))
        patch, clears = Signal(icu.patch_bits + 1), Signal(init=1)
        # The sum before the last one that is read; the last one is known a cycle before it is.
        before_end, last, reads = Signal(icu.patch_bits), Signal(), Signal()
        requests, accepts = Signal(), Signal()
        m.d.comb += [self.busy.eq(reads | clears | outstanding.any()), requests.eq(reads & (outstanding != capacity)),
                     self.i_read.ready.eq(~self.busy), self.i.ready.eq(~reads & ~clears & ~self.i_read.valid),
                     accepts.eq(self.i.valid & self.i.ready)]
        with m.If(clears | requests):
            m.d.sync += patch.eq(patch + 1)
        with m.If(requests):
            m.d.sync += last.eq(patch[:-1] == before_end)
        with m.If(clears & patch[:-1].all()):
            m.d.sync += [clears.eq(0), patch.eq(0)]
        with m.If(requests & last):
            m.d.sync += [reads.eq(0), patch.eq(0)]
        with m.If(self.i_read.valid & self.i_read.ready):
            m.d.sync += [before_end.eq(self.i_read.payload - 2), last.eq(self.i_read.payload == 1),
                         reads.eq(self.i_read.payload.any())]
        m.d.sync += outstanding.eq(outstanding + requests - (queue.o.valid & queue.o.ready))

        # A hit waits two cycles for its weight.
        hits = []
        before = {"hit": accepts & self.i.payload.hit.inverse.any(), "patch": self.i.payload.hit.patch}
        for _ in range(2):
            now = {"hit": Signal(), "patch": Signal(formats.patch, reset_less=True)}
            m.d.sync += [now[name].eq(before[name]) for name in now]
            hits.append(now)
            before = now
        weight_1, weight = (Signal(WEIGHT_BITS, reset_less=True) for _ in range(2))
        m.d.sync += [weight_1.eq(read.data), weight.eq(weight_1)]
        scans = clears | requests
        entry = sums.i.payload
        m.d.comb += [
            sums.i.valid.eq(before["hit"] | scans), entry.tag.reads.eq(requests & ~before["hit"]),
            entry.tag.last.eq(last),
            entry.operand.hit.eq(before["hit"]), entry.operand.clear.eq(~before["hit"]),
            entry.operand.weight.eq(weight), entry.address.eq(Mux(before["hit"], before["patch"], patch))]
        made = sums.o.payload
        m.d.comb += [queue.i.valid.eq(sums.o.valid & made.tag.reads), queue.i.payload.patch.eq(made.address),
                     queue.i.payload.sum.eq(made.old[:width]),
                     queue.i.payload.overflow.eq(made.old[width]), queue.i.payload.last.eq(made.tag.last)]
        # Hits in flight have priority.
        with m.If(hits[0]["hit"] | hits[1]["hit"]):
            m.d.comb += requests.eq(0)
        return m
