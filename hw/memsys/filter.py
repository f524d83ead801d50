"""Filter: lets each number pass once per frustum."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.credit_gate import CreditGate
from hw.lib.generations import Generations
from hw.lib.queue import Queue
from hw.lib.update_memory import UpdateMemory

__all__ = ["Filter"]


class Filter(wiring.Component):
    """A bit per number says whether it has passed; a word of bits has the tag of the generation that it is from.

    So a new generation needs no pass over the memory, until the tags run out. What does not pass takes its turn, so
    that items stay in order, and numbers that there are not never pass.

    Parameters
    ----------
    bits
        Of a number.
    count
        Numbers that there can be; a power of two, at least 2 ``word_bits``.
    generation_bits
        Of a tag.
    word_bits
        Numbers of a word; a power of two, at least 2.

    Members
    -------
    i_start
        Begins a generation: all numbers may pass again. Taken when nothing is under way, with a sweep when the tags
        have run out. Nothing is taken before the first one. No payload.
    i
        Numbers.
    limit
        Numbers that there are: 0 to ``limit`` - 1. The same while numbers are under way.
    o
        Those that pass.
    dropped, wrong, number
        A number that has passed before, or that there is not, has left in this cycle, and which.
    seen, passed
        Numbers that have left and that have passed in this generation.

    Timing
    ------
    Latency: ``6`` cycles. One number per cycle, whether it passes or not; stalls with ``o``; 8 in flight.

    Errors
    ------
    ValueError
        Sizes out of range.

    Golden counterpart: `golden.memsys.filter.Filter`. Source: Shen 1993, section 5.3.6.
    """

    # Numbers under way, enough for one per cycle.
    room = 8

    def __init__(self, *, bits: int, count: int, generation_bits: int, word_bits: int = 16):
        if not isinstance(word_bits, int) or word_bits < 2 or word_bits & (word_bits - 1):
            raise ValueError(f"Word bits must be a power of two of at least 2, not {word_bits!r}")
        if not isinstance(count, int) or count < 2 * word_bits or count & (count - 1):
            raise ValueError(f"Count must be a power of two of at least {2 * word_bits}, not {count!r}")
        if not isinstance(bits, int) or 1 << bits < count:
            raise ValueError(f"Bits must be at least {count.bit_length() - 1}, not {bits!r}")
        self._bits, self._count, self._word, self._generation = bits, count, word_bits, generation_bits
        super().__init__({
            "i_start": In(stream.Signature(0)), "i": In(stream.Signature(bits)), "limit": In(range(count + 1)),
            "o": Out(stream.Signature(range(count))), "dropped": Out(1), "wrong": Out(1), "number": Out(bits),
            "seen": Out(32), "passed": Out(32)})
        self.latency = 6

    def elaborate(self, platform):
        m = Module()
        word_bits, depth = self._word.bit_length() - 1, self._count // self._word
        m.submodules.gate = gate = CreditGate(self._bits, credits=self.room)
        m.submodules.generations = generations = Generations(bits=self._generation, depth=depth)
        begun = Signal()
        m.d.comb += [
            generations.i_start.valid.eq(self.i_start.valid & (gate.level == 0)),
            self.i_start.ready.eq(generations.i_start.ready & (gate.level == 0)),
            gate.i.payload.eq(self.i.payload)]
        with m.If(begun & ~self.i_start.valid):
            m.d.comb += [gate.i.valid.eq(self.i.valid), self.i.ready.eq(gate.i.ready)]

        # first is not read again: it is the answer to the access that has written the row.
        row = StructLayout({"generation": self._generation, "seen": self._word, "first": 1})
        operand = StructLayout({"generation": self._generation, "mask": self._word, "writes": 1})
        asked = StructLayout({"number": self._bits, "asks": 1, "wrong": 1})

        def change(old, operand):
            """The word after an access."""
            seen = Mux(old.generation == operand.generation, old.seen, 0)
            return Cat(operand.generation, seen | operand.mask, ~(seen & operand.mask).any()), operand.writes

        m.submodules.words = words = UpdateMemory(row, depth=depth, operand=operand, tag=asked, change=change)
        # A block RAM has no time for a choice in front of it.
        given, comes = Signal.like(words.i.payload, reset_less=True), Signal()
        number, sweeps, enters = gate.o.payload, generations.sweeps, gate.o.valid
        wrong = Signal()
        m.d.comb += [gate.o.ready.eq(1), wrong.eq(number >= self.limit), words.i.valid.eq(comes),
                     words.i.payload.eq(given)]
        m.d.sync += [
            comes.eq(enters | sweeps),
            given.address.eq(Mux(sweeps, generations.row, number[word_bits:self._count.bit_length() - 1])),
            given.tag.number.eq(number), given.tag.asks.eq(enters), given.tag.wrong.eq(wrong),
            given.operand.generation.eq(Mux(sweeps, 0, generations.generation)),
            given.operand.mask.eq(Mux(sweeps, 0, 1 << number[:word_bits])), given.operand.writes.eq(sweeps | ~wrong)]

        m.submodules.found = found = Queue(StructLayout({"number": self._bits, "passes": 1, "wrong": 1}),
                                           depth=self.room)
        made, leaves = words.o.payload, Signal()
        m.d.comb += [
            found.i.valid.eq(words.o.valid & made.tag.asks), found.i.payload.number.eq(made.tag.number),
            found.i.payload.wrong.eq(made.tag.wrong), found.i.payload.passes.eq(made.new.first & ~made.tag.wrong),
            self.o.valid.eq(found.o.valid & found.o.payload.passes), self.o.payload.eq(found.o.payload.number),
            found.o.ready.eq(self.o.ready | ~found.o.payload.passes),
            leaves.eq(found.o.valid & found.o.ready), gate.i_return.valid.eq(leaves),
            self.dropped.eq(leaves & ~found.o.payload.passes), self.wrong.eq(self.dropped & found.o.payload.wrong),
            self.number.eq(found.o.payload.number)]
        # Counted a cycle later: a long addition.
        left, went_on = Signal(), Signal()
        m.d.sync += [left.eq(leaves), went_on.eq(leaves & ~self.dropped), self.seen.eq(self.seen + left),
                     self.passed.eq(self.passed + went_on)]
        # So are they cleared, before the first number is back.
        starts, clears = self.i_start.valid & self.i_start.ready, Signal()
        m.d.sync += clears.eq(starts)
        with m.If(starts):
            m.d.sync += begun.eq(1)
        with m.If(clears):
            m.d.sync += [self.seen.eq(0), self.passed.eq(0)]
        return m
