"""Ray banks: ray memories side by side, so that a ray leaves while another one comes back."""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.ctu.ray_memory import RayMemory
from hw.lib.arbiter import Arbiter
from hw.lib.fork import Fork
from hw.lib.queue import Queue
from hw.lib.validate import check_integer

__all__ = ["RayBanks"]

# A power of two.
BANKS = 2
# Requests in front of each bank: so many more of one bank than of the others may come without a wait.
REQUESTS = 8


class RayBanks(wiring.Component):
    """A ray memory whose slots are in banks by the low bits of their numbers.

    A ray takes two accesses of its slot, when it leaves and when it is back, and a bank makes one per cycle. Requests
    for slots of one bank keep their order.

    Parameters
    ----------
    slots, version_bits, deferred, generation_bits, tag
        See `RayMemory`; of all banks together. ``slots`` and ``deferred`` are multiples of `BANKS`.

    Members
    -------
    i_start, i, i_return : In, streams; o : Out, stream; waiting : Out(range(deferred + 1))
        See `RayMemory`.
    o_passed : Out, array of streams of tags
        One for each bank, see `RayMemory`.

    Timing
    ------
    Latency: ``9`` cycles from ``i`` to ``o``, ``22`` from ``i_return`` to the ray that leaves again. A request and a
    return per cycle, if they are spread over the banks, of which each makes one access per cycle. Requests stall with
    ``o``, and while those that wait or are looked at take all entries of a bank; returns never stall.

    Raises
    ------
    TypeError, ValueError
        A size of the wrong type or out of range.

    Golden counterpart: `golden.engine.ctu.ray_memory.RayMemory`. Source: Shen 1993, Fig. 5.10 and section 5.3.4.4.
    """

    def __init__(self, *, slots: int, version_bits: int, deferred: int, generation_bits: int, tag):
        for name, value in (("Slots", slots), ("Deferred", deferred)):
            check_integer(name, value, minimum=BANKS)
            if value % BANKS:
                raise ValueError(f"{name} must be a multiple of the banks, not {value!r}")
        self._banks = [RayMemory(
            slots=slots // BANKS, version_bits=version_bits, deferred=deferred // BANKS,
            generation_bits=generation_bits, tag=tag) for _ in range(BANKS)]
        request = StructLayout({"slot": range(slots), "version": version_bits, "tag": tag})
        super().__init__({
            "i_start": In(stream.Signature(0)), "i": In(stream.Signature(request)),
            "i_return": In(stream.Signature(range(slots), always_ready=True)), "o": Out(stream.Signature(request)),
            "o_passed": Out(stream.Signature(tag, always_ready=True)).array(BANKS),
            "waiting": Out(range(deferred + 1))})
        self._merge = Arbiter(self._banks[0].o.payload.shape(), count=BANKS)
        self.latency = 1 + self._banks[0].latency + self._merge.latency

    def elaborate(self, platform):
        m = Module()
        bits = BANKS.bit_length() - 1
        m.submodules.starts, m.submodules.merge = starts, merge = Fork(0, count=BANKS), self._merge
        queues = [Queue(self._banks[0].i.payload.shape(), depth=REQUESTS) for _ in range(BANKS)]
        request, chosen = self.i.payload, self.i.payload.slot[:bits]
        free, empty = Signal(BANKS), Signal()
        m.d.comb += [
            # What was taken before a frustum's begin belongs to the one before.
            empty.eq(~Cat(queue.o.valid for queue in queues).any()), starts.i.valid.eq(self.i_start.valid & empty),
            self.i_start.ready.eq(starts.i.ready & empty),
            self.i.ready.eq(free.all() & ~self.i_start.valid)]
        for k, (bank, queue) in enumerate(zip(self._banks, queues, strict=True)):
            m.submodules[f"bank_{k}"], m.submodules[f"queue_{k}"] = bank, queue
            wiring.connect(m, starts.o[k], bank.i_start)
            wiring.connect(m, queue.o, bank.i)
            wiring.connect(m, bank.o, merge.i[k])
            m.d.comb += [
                free[k].eq(queue.i.ready), queue.i.valid.eq(self.i.valid & self.i.ready & (chosen == k)),
                queue.i.payload.slot.eq(request.slot[bits:]),
                *(queue.i.payload[name].eq(request[name]) for name in ("version", "tag")),
                bank.i_return.valid.eq(self.i_return.valid & (self.i_return.payload[:bits] == k)),
                bank.i_return.payload.eq(self.i_return.payload[bits:]),
                self.o_passed[k].valid.eq(bank.o_passed.valid), self.o_passed[k].payload.eq(bank.o_passed.payload)]
        made, shown = merge.o.payload, self.o.payload
        m.d.comb += [
            self.o.valid.eq(merge.o.valid), merge.o.ready.eq(self.o.ready),
            shown.slot.eq(Cat(made.source, made.item.slot)),
            *(shown[name].eq(made.item[name]) for name in ("version", "tag"))]
        m.d.sync += self.waiting.eq(sum(bank.waiting for bank in self._banks))
        return m
