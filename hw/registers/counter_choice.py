"""CounterChoice: the value of one of many counters."""

from amaranth.hdl import Array, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.data import ArrayLayout
from amaranth.lib.wiring import In, Out

__all__ = ["CounterChoice"]


class CounterChoice(wiring.Component):
    """One of the counters of several places of a chip; of each place one counter crosses it.

    Parameters
    ----------
    places
        How many counters each place has.
    number_bits
        Of a counter's number.

    Members
    -------
    counts
        The counters, place by place.
    counter, count
        Which of them, and its value. Of a number that no counter has, anything.

    Timing
    ------
    Latency: ``3`` cycles; the value is that of the cycle behind the number's. One number per cycle; never stalls.

    Errors
    ------
    ValueError
        The numbers have too few bits for the counters.
    """

    # The same wherever it is, and whoever asks has to wait.
    latency = 3

    def __init__(self, *, places: tuple[int, ...], number_bits: int):
        if sum(places) > 1 << number_bits:
            raise ValueError(f"Number bits must be enough for {sum(places)} counters, not {number_bits!r}")
        self._places = places
        super().__init__({"counts": In(ArrayLayout(32, sum(places))), "counter": In(number_bits), "count": Out(32)})

    def elaborate(self, platform):
        m = Module()
        counter, before, first = Signal.like(self.counter), Signal.like(self.counter), 0
        m.d.sync += [counter.eq(self.counter), before.eq(counter)]
        for place in self._places:
            counts, chosen = [self.counts[number] for number in range(first, first + place)], Signal(32)
            m.d.sync += chosen.eq(Array(counts)[(counter - first)[:len(counter)]])
            with m.If(before >= first):
                m.d.sync += self.count.eq(chosen)
            first += place
        return m
