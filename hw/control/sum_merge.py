"""Sum merge: adds the sums of all clusters, patch by patch."""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.lib.validate import check_integer

__all__ = ["SumMerge"]


class SumMerge(wiring.Component):
    """Adds the clusters' sums of each patch in a tree of two-input adders.

    Parameters
    ----------
    config
        The configuration.
    count
        Number of inputs, at least 1.

    Members
    -------
    i : In, ``count`` streams of `IcuFormats.patch_sum`
        The sums of each cluster: the same patches in the same order.
    o : Out, stream of `IcuFormats.patch_sum`
        The sums of all clusters; ``overflow`` if one of them has it, or if their sum is too large.

    Timing
    ------
    Latency: ``1 + bits(count - 1)`` cycles. One sum per cycle; stalls with ``o`` and with the slowest input.

    Raises
    ------
    TypeError
        The count is no integer.
    ValueError
        The count is out of range.

    Golden counterpart: `golden.icu.collector.collect`.
    """

    def __init__(self, *, config: Config, count: int):
        check_integer("Count", count, minimum=1)
        formats = IcuFormats(config)
        self._item = stream.Signature(formats.patch_sum)
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
            total = sum(one.payload.sum for one in given)
            m.d.sync += [out.valid.eq(all_there), out.payload.eq(given[0].payload), out.payload.sum.eq(total),
                         out.payload.overflow.eq(Cat(total >> len(out.payload.sum), *(
                             one.payload.overflow for one in given)).any())]
        return out
