"""Sum merge: the sums of all clusters, patch by patch."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.icu.icu_formats import IcuFormats

__all__ = ["SumMerge"]


class SumMerge(wiring.Component):
    """Adds what stands at the same patch, two and two.

    Parameters
    ----------
    config
        The configuration.
    count
        Inputs, at least 1.

    Members
    -------
    i
        An array of ``patch``, ``sum``, ``last``: the same patches in the same order.
    o
        The same.

    Timing
    ------
    Latency: ``1 + bits(count - 1)`` cycles. One sum per cycle; stalls with ``o`` and with the slowest input.

    Errors
    ------
    ValueError
        Count out of range.

    Golden counterpart: `golden.icu.collector.collect`.
    """

    def __init__(self, *, config: Config, count: int):
        if not isinstance(count, int) or count < 1:
            raise ValueError(f"Count must be at least 1, not {count!r}")
        formats = IcuFormats(config)
        self._item = stream.Signature(StructLayout({"patch": formats.patch, "sum": formats.weight_sum, "last": 1}))
        super().__init__({"i": In(self._item).array(count), "o": Out(self._item)})
        self.latency = 1 + (count - 1).bit_length()

    def elaborate(self, platform):
        m = Module()
        level = list(self.i)
        for depth in range(self.latency):
            level = [self._add(m, level[k:k + 2], f"sum_{depth}_{k // 2}") for k in range(0, len(level), 2)]
        (last,) = level
        wiring.connect(m, last, wiring.flipped(self.o))
        return m

    def _add(self, m, given, name):
        """A register with the sum of one or two items."""
        out, free, all_there = self._item.create(path=(name,)), Signal(), Signal()
        m.d.comb += [free.eq(~out.valid | out.ready), all_there.eq(1)]
        for one in given:
            with m.If(~one.valid):
                m.d.comb += all_there.eq(0)
            m.d.comb += one.ready.eq(free & all_there)
        with m.If(free):
            m.d.sync += [out.valid.eq(all_there), out.payload.eq(given[0].payload),
                         out.payload.sum.eq(sum(one.payload.sum for one in given))]
        return out
