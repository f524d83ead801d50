"""Counter choice: the value of one of many counters."""

from amaranth.hdl import Array, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.data import ArrayLayout
from amaranth.lib.wiring import In, Out

__all__ = ["CounterChoice"]


class CounterChoice(wiring.Component):
    """Selects a counter in two steps: one of each group, then one of the groups.

    A group is placed near its counters, so one counter of each group crosses the chip.

    Parameters
    ----------
    groups
        The number of counters of each group.
    number_bits
        Of the number of a counter.

    Members
    -------
    counts : In(ArrayLayout(32, counters))
        The counters, group after group.
    counter : In(number_bits)
        The number of a counter.
    count : Out(32)
        Its value; undefined where there is no such counter.

    Timing
    ------
    Latency: ``3`` cycles; the value is that of the cycle after the number. One number per cycle; never stalls.

    Raises
    ------
    ValueError
        There are more counters than numbers.
    """

    latency = 3

    def __init__(self, *, groups: tuple[int, ...], number_bits: int):
        if sum(groups) > 1 << number_bits:
            raise ValueError(f"Number bits must be enough for {sum(groups)} counters, not {number_bits!r}")
        self._groups = groups
        super().__init__({"counts": In(ArrayLayout(32, sum(groups))), "counter": In(number_bits), "count": Out(32)})

    def elaborate(self, platform):
        m = Module()
        counter, previous, first = Signal.like(self.counter), Signal.like(self.counter), 0
        m.d.sync += [counter.eq(self.counter), previous.eq(counter)]
        for group in self._groups:
            counts, chosen = [self.counts[number] for number in range(first, first + group)], Signal(32)
            index = Signal.like(self.counter)
            m.d.sync += [index.eq(self.counter - first), chosen.eq(Array(counts)[index])]
            with m.If(previous >= first):
                m.d.sync += self.count.eq(chosen)
            first += group
        return m
