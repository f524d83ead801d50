"""Fully associative placement: the line of a record."""

from amaranth.hdl import Array, Cat, Const, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.validate import check_integer, check_power_of_two

__all__ = ["LfuPlacement"]

MOST_LINES = 64


class LfuPlacement(wiring.Component):
    """Fully associative: a record may be in any line. A miss replaces the line used least often since it was filled.

    All keys are compared at once. After a miss the least count is searched bit by bit from the highest one: of the
    candidates, those with a 0 there remain, if there are any. Of the last ones, the lines after the one that was filled
    last come first. An empty line has count 0.

    Parameters
    ----------
    lines
        A power of two, 2 to 64.
    key, tag
        Shapes of a key, and of a sideband value of a request.
    count_bits
        Of a counter, which saturates.

    Members
    -------
    i_start : In, stream without payload
        Empties all lines. Only while no request is in flight. Always ready.
    i : In, stream of ``tag``, ``key``
        Requests.
    o : Out, stream of ``tag``, ``line``, ``hit``
        Their lines. Always ready.

    Timing
    ------
    Latency: ``3`` cycles of a hit. One hit per cycle; a miss takes ``lfu_count_bits + 5`` cycles, ``latency_of_miss``
    in all, and stalls ``i``; 2 requests in flight.

    Raises
    ------
    TypeError
        A number is no integer.
    ValueError
        A number is out of range.

    Golden counterpart: `golden.engine.memsys.bus.lfu_placement.LfuPlacement`. Source: Shen 1993, section 5.3.7.
    """

    latency = 3

    def __init__(self, *, lines: int, key, tag, count_bits: int):
        check_power_of_two("Lines", lines, minimum=2, maximum=MOST_LINES)
        check_integer("Count bits", count_bits, minimum=1)
        self._lines, self._count_bits, self._key = lines, count_bits, key
        super().__init__({
            "i_start": In(stream.Signature(0, always_ready=True)),
            "i": In(stream.Signature(StructLayout({"tag": tag, "key": key}))),
            "o": Out(stream.Signature(StructLayout({"tag": tag, "line": range(lines), "hit": 1}), always_ready=True))})
        self.latency_of_miss = self.latency + count_bits + 4

    def elaborate(self, platform):
        m = Module()
        lines, count_bits = self._lines, self._count_bits
        keys = Array(Signal(self._key, reset_less=True, name=f"key_{k}") for k in range(lines))
        counts = Array(Signal(count_bits, name=f"count_{k}") for k in range(lines))
        # Two requests: one that is being compared, and one after that, with the lines that hold it.
        compares, knows, advance = Signal(), Signal(), Signal()
        compared, known = (Signal.like(self.i.payload, reset_less=True, name=name) for name in ("compared", "known"))
        held, missed = Signal(lines, reset_less=True), Signal()
        m.d.comb += self.i.ready.eq(~compares | advance)
        with m.If(self.i.ready):
            m.d.sync += [compares.eq(self.i.valid), compared.eq(self.i.payload)]
        with m.If(advance):
            m.d.sync += [knows.eq(compares), known.eq(compared), held.eq(
                Cat((key == compared.key) & count.any() for key, count in zip(keys, counts, strict=True)))]

        # The search: candidates, those of them with a 0 in the present bit, and the bits of the next step. The lowest
        # digit is 0 of the lines after the one filled last.
        candidates, ones, after = Signal(lines, reset_less=True), Signal(lines, reset_less=True), Signal(lines, init=-1)
        step = Signal(range(count_bits + 1))
        zeros, found = Signal(lines), Signal()
        m.d.comb += [found.eq(held.any()), zeros.eq(candidates & ~ones)]
        fills = Signal()
        with m.FSM():
            with m.State("COMPARE"):
                m.d.comb += advance.eq(~knows | found)
                m.d.sync += [candidates.eq(-1), step.eq(0), ones.eq(Cat(count[-1] for count in counts))]
                with m.If(knows & ~found):
                    m.d.sync += missed.eq(1)
                    m.next = "SEARCH"
            with m.State("SEARCH"):
                m.d.sync += step.eq(step + 1)
                for k, count in enumerate(counts):
                    digits = Array([*(count[bit] for bit in range(count_bits - 2, -1, -1)), ~after[k], Const(0)])
                    m.d.sync += ones[k].eq(digits[step])
                with m.If(zeros.any()):
                    m.d.sync += candidates.eq(zeros)
                with m.If(step == count_bits):
                    m.next = "CHOOSE"
            with m.State("CHOOSE"):
                m.d.sync += held.eq(candidates & ~(candidates - 1))
                m.next = "FILL"
            with m.State("FILL"):
                m.d.comb += fills.eq(1)
                m.d.sync += after.eq(~(held | (held - 1)))
                m.next = "ANSWER"
            with m.State("ANSWER"):
                # The next request is compared with the new key.
                m.d.comb += advance.eq(1)
                m.d.sync += missed.eq(0)
                m.next = "COMPARE"

        for k in range(lines):
            with m.If(fills & held[k]):
                m.d.sync += [keys[k].eq(known.key), counts[k].eq(1)]
            with m.Elif(knows & ~missed & held[k] & ~counts[k].all()):
                m.d.sync += counts[k].eq(counts[k] + 1)
            with m.If(self.i_start.valid):
                m.d.sync += counts[k].eq(0)
        with m.If(self.i_start.valid):
            m.d.sync += after.eq(-1)

        m.d.sync += [
            self.o.valid.eq(knows & advance), self.o.payload.tag.eq(known.tag), self.o.payload.hit.eq(~missed),
            self.o.payload.line.eq(Cat(Cat(held[k] for k in range(lines) if k >> bit & 1).any()
                                       for bit in range(lines.bit_length() - 1)))]
        return m
