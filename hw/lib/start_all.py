"""Start of several units: each begins once, and all have begun before any goes on."""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hw.lib.validate import check_integer

__all__ = ["StartAll"]


class StartAll(wiring.Component):
    """Starts ``count`` units together and waits until each has accepted.

    All outputs come from registers: the units may be far from each other and from what starts them.

    Parameters
    ----------
    count
        Number of units, at least 1.

    Members
    -------
    i : In, stream without payload
        Starts the units; accepted when all of them have begun.
    which : In(count)
        The units that begin, a bit for each; initially all. Read in the first cycle of ``i``.
    o : Out, ``count`` streams without payload
        Starts of the units, each accepted in a cycle of its own.

    Timing
    ------
    Latency: ``1`` cycle from ``i`` to ``o``; ``i`` is accepted the cycle after the last unit has begun. One start every
    3 cycles at most.

    Raises
    ------
    TypeError
        The count is no integer.
    ValueError
        The count is out of range.
    """

    latency = 1

    def __init__(self, *, count: int):
        check_integer("Count", count, minimum=1)
        self._count = count
        super().__init__({"i": In(stream.Signature(0)), "which": In(count, init=(1 << count) - 1),
                          "o": Out(stream.Signature(0)).array(count)})

    def elaborate(self, platform):
        m = Module()
        runs, starts = Signal(), Signal(self._count)
        m.d.comb += [self.i.ready.eq(runs & ~starts.any()),
                     *(output.valid.eq(start) for output, start in zip(self.o, starts, strict=True))]
        m.d.sync += [runs.eq(self.i.valid & ~self.i.ready),
                     starts.eq(starts & ~Cat(output.ready for output in self.o))]
        with m.If(self.i.valid & ~runs):
            m.d.sync += starts.eq(self.which)
        return m
