"""Fully associative placement: which line a record is in, or will be."""

from amaranth.hdl import Array, Cat, Const, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

__all__ = ["LfuPlacement"]

MOST_LINES = 64


class LfuPlacement(wiring.Component):
    """Any line; the one goes that has been used least often since it was filled.

    All keys are compared at once. After a miss the least count is found bit by bit, from the highest one: the lines
    that have a 0 there stay, if there are any. Of those that stay, the lines after the one that was filled last come
    first. An empty line has count 0.

    Parameters
    ----------
    lines
        A power of two, 2 to 64.
    key, tag
        Shapes of a key, and of what goes along.
    count_bits
        Of a counter; a count stays at 2^``count_bits`` - 1.

    Members
    -------
    i_start
        Empties all lines. The sender sees to it that no request is under way. No payload, always ready.
    i
        ``tag`` and ``key``.
    o
        ``tag``, ``line``, and whether it is a ``hit``. Always ready.

    Timing
    ------
    Latency: ``3`` cycles of a hit. One hit per cycle; a miss takes ``lfu_count_bits + 5`` cycles, ``latency_of_miss``
    in all, and stalls ``i``; 2 requests in flight.

    Errors
    ------
    ValueError
        Lines or count bits out of range.

    Golden counterpart: `golden.memsys.lfu_placement.LfuPlacement`. Source: Shen 1993, section 5.3.7.
    """

    latency = 3

    def __init__(self, *, lines: int, key, tag, count_bits: int):
        if not isinstance(lines, int) or not 2 <= lines <= MOST_LINES or lines & (lines - 1):
            raise ValueError(f"Lines must be a power of two from 2 to {MOST_LINES}, not {lines!r}")
        if not isinstance(count_bits, int) or count_bits < 1:
            raise ValueError(f"Count bits must be at least 1, not {count_bits!r}")
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
        # Two requests: one that is being compared, and one of which it is known which lines hold it.
        asks, knows, goes = Signal(), Signal(), Signal()
        asked, known = (Signal.like(self.i.payload, reset_less=True, name=name) for name in ("asked", "known"))
        held, missed = Signal(lines, reset_less=True), Signal()
        m.d.comb += self.i.ready.eq(~asks | goes)
        with m.If(self.i.ready):
            m.d.sync += [asks.eq(self.i.valid), asked.eq(self.i.payload)]
        with m.If(goes):
            m.d.sync += [knows.eq(asks), known.eq(asked), held.eq(
                Cat((key == asked.key) & count.any() for key, count in zip(keys, counts, strict=True)))]

        # The search: which lines may still go, those of them that have a 0 in the bit that is looked at, and the bits
        # of the next step. The lowest digit is whether a line is not after the one filled last.
        may_go, ones, after = Signal(lines, reset_less=True), Signal(lines, reset_less=True), Signal(lines, init=-1)
        step = Signal(range(count_bits + 1))
        zeros, found = Signal(lines), Signal()
        m.d.comb += [found.eq(held.any()), zeros.eq(may_go & ~ones)]
        fills = Signal()
        with m.FSM():
            with m.State("LOOK"):
                m.d.comb += goes.eq(~knows | found)
                m.d.sync += [may_go.eq(-1), step.eq(0), ones.eq(Cat(count[-1] for count in counts))]
                with m.If(knows & ~found):
                    m.d.sync += missed.eq(1)
                    m.next = "SEARCH"
            with m.State("SEARCH"):
                m.d.sync += step.eq(step + 1)
                for k, count in enumerate(counts):
                    digits = Array([*(count[bit] for bit in range(count_bits - 2, -1, -1)), ~after[k], Const(0)])
                    m.d.sync += ones[k].eq(digits[step])
                with m.If(zeros.any()):
                    m.d.sync += may_go.eq(zeros)
                with m.If(step == count_bits):
                    m.next = "CHOOSE"
            with m.State("CHOOSE"):
                m.d.sync += held.eq(may_go & ~(may_go - 1))
                m.next = "FILL"
            with m.State("FILL"):
                m.d.comb += fills.eq(1)
                m.d.sync += after.eq(~(held | (held - 1)))
                m.next = "ANSWER"
            with m.State("ANSWER"):
                # The next request is compared with the new key.
                m.d.comb += goes.eq(1)
                m.d.sync += missed.eq(0)
                m.next = "LOOK"

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
            self.o.valid.eq(knows & goes), self.o.payload.tag.eq(known.tag), self.o.payload.hit.eq(~missed),
            self.o.payload.line.eq(Cat(Cat(held[k] for k in range(lines) if k >> bit & 1).any()
                                       for bit in range(lines.bit_length() - 1)))]
        return m
