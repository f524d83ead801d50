"""Filter: passes each number once per frustum."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.credit_gate import CreditGate
from hw.lib.generations import Generations
from hw.lib.queue import Queue
from hw.lib.update_memory import UpdateMemory
from hw.lib.validate import check_integer, check_power_of_two

__all__ = ["Filter"]


class Filter(wiring.Component):
    """Passes each number once per generation, with a bit for each number.

    A word of bits has the tag of the generation that it is from. So a new generation needs no pass over the memory
    until the tags run out. Numbers stay in order; numbers that do not exist never pass.

    Parameters
    ----------
    bits
        Of a number.
    count
        Numbers that can exist; a power of two, at least 2 ``word_bits``.
    generation_bits
        Of a tag.
    word_bits
        Numbers of a word; a power of two, at least 2.

    Members
    -------
    i_start : In, stream without payload
        Begins a generation: all numbers may pass again. Accepted when no number is in flight, and the words of the
        numbers that exist have been swept if the tags had run out. No number is accepted before the first generation.
    i : In, stream of ``bits`` bits
        Numbers.
    limit : In(range(count + 1))
        The numbers 0 to ``limit`` - 1 exist. Stable while numbers are in flight, and from the cycle before ``i_start``
        on.
    o : Out, stream of a number below ``count``
        The numbers that pass.
    dropped, wrong : Out(1)
        In this cycle a number leaves that has passed before, or that does not exist (``wrong``).
    number : Out(bits)
        That number.
    seen, passed : Out(32)
        Numbers of this generation that have left, and that have passed.

    Timing
    ------
    Latency: ``6`` cycles. One number per cycle, whether it passes or not; stalls with ``o``; 8 in flight. A sweep, of a
    word per cycle, begins at reset, and every 2^``generation_bits`` - 1 generations with ``i_start``; beyond ``limit``
    it goes on in cycles without a number.

    Raises
    ------
    TypeError
        A size is no integer.
    ValueError
        A size is out of range.

    Golden counterpart: `golden.engine.memsys.patches.filter.Filter`. Source: Shen 1993, section 5.3.6.
    """

    # Numbers in flight, enough for one per cycle.
    capacity = 8

    def __init__(self, *, bits: int, count: int, generation_bits: int, word_bits: int = 16):
        check_power_of_two("Word bits", word_bits, minimum=2)
        check_power_of_two("Count", count, minimum=2 * word_bits)
        check_integer("Bits", bits, minimum=count.bit_length() - 1)
        self._bits, self._count, self._word, self._generation = bits, count, word_bits, generation_bits
        super().__init__({
            "i_start": In(stream.Signature(0)), "i": In(stream.Signature(bits)), "limit": In(range(count + 1)),
            "o": Out(stream.Signature(range(count))), "dropped": Out(1), "wrong": Out(1), "number": Out(bits),
            "seen": Out(32), "passed": Out(32)})
        self.latency = 6

    def elaborate(self, platform):
        m = Module()
        word_bits, depth = self._word.bit_length() - 1, self._count // self._word
        m.submodules.gate = gate = CreditGate(self._bits, credits=self.capacity)
        m.submodules.generations = generations = Generations(bits=self._generation, depth=depth)
        begun = Signal()
        # Registered: the sum and the comparison behind it are two carry chains.
        rows = Signal.like(generations.rows)
        m.d.sync += rows.eq((self.limit + self._word - 1) >> word_bits)
        m.d.comb += [
            generations.i_start.valid.eq(self.i_start.valid & (gate.level == 0)), generations.idle.eq(~begun),
            generations.rows.eq(rows), generations.busy.eq(gate.o.valid),
            self.i_start.ready.eq(generations.i_start.ready & (gate.level == 0)),
            gate.i.payload.eq(self.i.payload)]
        with m.If(begun & ~self.i_start.valid):
            m.d.comb += [gate.i.valid.eq(self.i.valid), self.i.ready.eq(gate.i.ready)]

        # ``first`` is never read from the memory: it is the result of the access that writes the row.
        row = StructLayout({"generation": self._generation, "seen": self._word, "first": 1})
        operand = StructLayout({"generation": self._generation, "mask": self._word, "writes": 1})
        tag = StructLayout({"number": self._bits, "is_number": 1, "wrong": 1})

        def change(_, old, operand):
            """The word after an access."""
            is_current, again = old.generation == operand.generation, (old.seen & operand.mask).any()
            seen = Mux(is_current, old.seen, 0)
            return Cat(operand.generation, seen | operand.mask, ~(is_current & again)), operand.writes

        m.submodules.words = words = UpdateMemory(row, depth=depth, operand=operand, tag=tag, change=change)
        # Registered: a block RAM has no slack for a multiplexer at its address.
        given, accesses = Signal.like(words.i.payload, reset_less=True), Signal()
        number, sweeps, enters = gate.o.payload, generations.sweeps, gate.o.valid
        wrong = Signal()
        m.d.comb += [gate.o.ready.eq(1), wrong.eq(number >= self.limit), words.i.valid.eq(accesses),
                     words.i.payload.eq(given)]
        # Whether a row is swept is known later than whether a number enters.
        m.d.sync += [
            accesses.eq(enters | sweeps),
            given.address.eq(Mux(enters, number[word_bits:self._count.bit_length() - 1], generations.row)),
            given.tag.number.eq(number), given.tag.is_number.eq(enters), given.tag.wrong.eq(wrong),
            given.operand.generation.eq(Mux(enters, generations.generation, 0)),
            given.operand.mask.eq(Mux(enters, 1 << number[:word_bits], 0)), given.operand.writes.eq(~(enters & wrong))]

        m.submodules.found = found = Queue(StructLayout({"number": self._bits, "passes": 1, "wrong": 1}),
                                           depth=self.capacity)
        done, leaves = words.o.payload, Signal()
        m.d.comb += [
            found.i.valid.eq(words.o.valid & done.tag.is_number), found.i.payload.number.eq(done.tag.number),
            found.i.payload.wrong.eq(done.tag.wrong), found.i.payload.passes.eq(done.new.first & ~done.tag.wrong),
            self.o.valid.eq(found.o.valid & found.o.payload.passes), self.o.payload.eq(found.o.payload.number),
            found.o.ready.eq(self.o.ready | ~found.o.payload.passes),
            leaves.eq(found.o.valid & found.o.ready), gate.i_return.valid.eq(leaves),
            self.dropped.eq(leaves & ~found.o.payload.passes), self.wrong.eq(self.dropped & found.o.payload.wrong),
            self.number.eq(found.o.payload.number)]
        # Registered: the counters are wide.
        left, went = Signal(), Signal()
        m.d.sync += [left.eq(leaves), went.eq(leaves & ~self.dropped), self.seen.eq(self.seen + left),
                     self.passed.eq(self.passed + went)]
        # They are cleared as late, before the first number leaves.
        starts, clears = self.i_start.valid & self.i_start.ready, Signal()
        m.d.sync += clears.eq(starts)
        with m.If(starts):
            m.d.sync += begun.eq(1)
        with m.If(clears):
            m.d.sync += [self.seen.eq(0), self.passed.eq(0)]
        return m
