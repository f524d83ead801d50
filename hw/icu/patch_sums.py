"""Patch sums: the sums of the weights of one section's rays, by patch."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import WEIGHT_BITS, IcuFormats, TableKind
from hw.lib.checks import claim, count_entries, count_steps
from hw.lib.queue import Queue
from hw.lib.update_memory import UpdateMemory

__all__ = ["PatchSums"]

# Cycles after a hit in which it is not yet in the list.
SETTLED = 7
# Sums that can wait at the output.
CAPACITY = 16


class PatchSums(wiring.Component):
    """Adds the weight of each ray that hit a patch to the patch's sum, and lists the patches in the order in which they
    first occur with a weight that is not 0.

    A read gives the sums of the patches in the list, and clears these sums and the list: the next section begins at 0.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of ``row``, ``hit``
        Row of the frustum and `IcuFormats.hit` of a ray. At most ``rays`` between two reads. Stalls while the list is
        read, and while sums are cleared.
    i_table : In, stream of `IcuFormats.table_write`, always ready
        Entries of WEIGHT are stored. The sender must not write a row in the cycle in which a hit of it arrives.
    i_read : In, stream without a payload
        Begins a read; accepted when the hits before it are in the sums. From the cycle after the offer on no hit is
        accepted until the list has been read.
    patches : In(range(2^patch_bits + 1))
        Patches of the scene: hits are of those below it. Must not rise during a read. Initially all that have a
        number.
    o : Out, stream of `IcuFormats.section_sum`
        The sums, or one item without ``is_sum`` if the list is empty.

    Timing
    ------
    Latency: ``8`` cycles from a read to its first item. A read is accepted one cycle after its offer, and 8 after the
    last hit at the earliest. One hit per cycle, one sum per cycle. A read of n sums stalls hits for max(1, n) cycles
    after its acceptance, longer if ``o`` stalls; 16 items wait at ``o`` beside the next section's hits. The sums below
    ``patches`` are cleared after reset, one per cycle, and further ones when ``patches`` exceeds them.

    Golden counterpart: `golden.engine.icu.patch_sums.section_sums`.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, IcuFormats(config)
        formats = self._formats
        super().__init__({
            "i": In(stream.Signature(StructLayout({"row": formats.index, "hit": formats.hit}))),
            "i_table": In(stream.Signature(formats.table_write, always_ready=True)),
            "i_read": In(stream.Signature(0)),
            "patches": In(range((1 << config.icu.patch_bits) + 1), init=1 << config.icu.patch_bits),
            "o": Out(stream.Signature(formats.section_sum))})
        self.latency = 8

    def elaborate(self, platform):
        m = Module()
        formats, icu = self._formats, self._config.icu
        operand = StructLayout({"weight": WEIGHT_BITS, "clear": 1})
        tag = StructLayout({"adds": 1, "reads": 1, "is_sum": 1, "last": 1})

        def change(_, old, operand):
            # The bit above the sum is set by the first carry and stays. A weight of 0 changes nothing.
            total = old[:WEIGHT_BITS] + operand.weight
            return Mux(operand.clear, 0, Cat(total[:WEIGHT_BITS], old[WEIGHT_BITS] | total[WEIGHT_BITS])), True

        m.submodules.sums = sums = UpdateMemory(
            WEIGHT_BITS + 1, depth=1 << icu.patch_bits, operand=operand, tag=tag, change=change)
        weight_0 = self._add_weights(m)

        # A read: hits stop, those in flight reach the list, then the list goes through the sums.
        hits_enter, clears, reads = Signal(), Signal(init=1), Signal()
        in_flight, cleared = Signal(SETTLED), Signal(icu.patch_bits + 1)
        accepts, begins = self.i.valid & self.i.ready, self.i_read.valid & self.i_read.ready
        m.d.comb += [self.i.ready.eq(hits_enter),
                     self.i_read.ready.eq(~hits_enter & ~clears & ~reads & ~in_flight.any())]
        m.d.sync += [in_flight.eq(Cat(accepts, in_flight)), hits_enter.eq(~clears & ~reads & ~self.i_read.valid)]
        # Registered: one sum more is cleared, in which there is nothing yet.
        m.d.sync += [clears.eq(cleared < self.patches), cleared.eq(cleared + clears)]

        # The list: a section has at most as many patches as rays.
        depth = min(1 << icu.patch_bits, icu.rays)
        m.submodules.list = patches = Memory(shape=formats.patch, depth=depth, init=[], attrs={"no_rw_check": 1})
        write, read = patches.write_port(), patches.read_port(domain="comb")
        count, index, requests, last = Signal(range(depth + 1)), Signal(range(depth)), Signal(), Signal()
        outstanding = Signal(range(CAPACITY + 1))
        m.submodules.queue = queue = Queue(self.o.payload.shape(), depth=CAPACITY)
        wiring.connect(m, queue.o, wiring.flipped(self.o))
        # The read is known to end with the next item a cycle before it does.
        before_end = Signal.like(count)
        m.d.comb += [requests.eq(reads & (outstanding != CAPACITY)), read.addr.eq(index)]
        returns = queue.o.valid & queue.o.ready
        count_entries(outstanding)
        count_steps(m, outstanding, up=requests, down=returns, most=CAPACITY)
        claim(m, ~queue.i.valid | queue.i.ready, "a sum has an entry")
        has_sums = Signal()
        with m.If(begins):
            m.d.sync += [reads.eq(1), index.eq(0), before_end.eq(count - 2), last.eq(count[1:] == 0),
                         has_sums.eq(count != 0)]
        with m.If(requests):
            m.d.sync += [index.eq(index + 1), last.eq(index == before_end)]
            with m.If(last):
                m.d.sync += [reads.eq(0), count.eq(0), hits_enter.eq(~self.i_read.valid)]

        # A hit waits two cycles for its weight, a read for its patch in the list.
        stages = []
        before = {"hits": accepts & self.i.payload.hit.inverse.any(), "reads": requests, "is_sum": has_sums,
                  "last": last}
        for _ in range(2):
            now = {name: Signal(name=f"{name}_{len(stages) + 1}") for name in before}
            m.d.sync += [now[name].eq(before[name]) for name in before]
            stages.append(now)
            before = now
        hit_patch, listed, address = (Signal(formats.patch, reset_less=True, name=name) for name in (
            "hit_patch", "listed", "address"))
        weight, clearing = Signal(WEIGHT_BITS, reset_less=True), Signal()
        m.d.sync += [
            hit_patch.eq(self.i.payload.hit.patch), listed.eq(read.data), weight.eq(weight_0),
            clearing.eq(clears),
            address.eq(Mux(clears, cleared[:icu.patch_bits], Mux(stages[0]["reads"], listed, hit_patch)))]
        entry, now = sums.i.payload, stages[1]
        m.d.comb += [
            sums.i.valid.eq(now["hits"] | now["reads"] | clearing), entry.address.eq(address),
            entry.operand.weight.eq(weight), entry.operand.clear.eq(~now["hits"]),
            entry.tag.adds.eq(now["hits"] & weight.any()), entry.tag.reads.eq(now["reads"]),
            entry.tag.is_sum.eq(now["is_sum"]), entry.tag.last.eq(now["last"])]

        made, out = sums.o.payload, queue.i.payload
        m.d.comb += [queue.i.valid.eq(sums.o.valid & made.tag.reads), out.patch.eq(made.address),
                     Cat(out.sum, out.overflow).eq(made.old), out.is_sum.eq(made.tag.is_sum),
                     out.last.eq(made.tag.last)]
        is_first, touched = Signal(), Signal(formats.patch, reset_less=True)
        m.d.sync += [is_first.eq(sums.o.valid & made.tag.adds & (made.old == 0)), touched.eq(made.address)]
        claim(m, ~is_first | (count != depth), "the list has an entry")
        claim(m, ~is_first | ~(begins | reads), "a hit is in the list before it is read")
        m.d.comb += [write.en.eq(is_first), write.addr.eq(count), write.data.eq(touched)]
        with m.If(is_first):
            m.d.sync += count.eq(count + 1)
        return m

    def _add_weights(self, m):
        """The table of weights; the weight of a hit a cycle after it."""
        m.submodules.weights = weights = Memory(shape=WEIGHT_BITS, depth=1 << self._config.icu.side_bits, init=[],
                                                attrs={"no_rw_check": 1})
        write, read = weights.write_port(), weights.read_port(domain="comb")
        given, weight = self.i_table, Signal(WEIGHT_BITS, reset_less=True)
        m.d.comb += [write.addr.eq(given.payload.index), write.data.eq(given.payload.data),
                     write.en.eq(given.valid & (given.payload.kind == TableKind.WEIGHT)),
                     read.addr.eq(self.i.payload.row)]
        m.d.sync += weight.eq(read.data)
        return weight
