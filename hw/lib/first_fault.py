"""First fault: the first of several faults, until it is cleared."""

from amaranth.hdl import Module, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.validate import check_integer

__all__ = ["FirstFault"]


class FirstFault(wiring.Component):
    """Latches the first fault until it is cleared; of two in the same cycle that of the lower input.

    A fault is an event, reported once: one in the cycle of a clear is latched, as if it came after it. An urgent one
    replaces an earlier one.

    Parameters
    ----------
    layout
        Of a fault. Its ``code`` is 0 while there is none.
    count
        Number of inputs, at least 1.
    urgent
        A code of input 0, if any.

    Members
    -------
    i : In, ``count`` streams of ``layout``
        Faults. Always ready.
    clear : In(1)
        Clears the latch, of earlier faults.
    o : Out(layout)
        The fault, all 0 while there is none.

    Timing
    ------
    Latency: ``1`` cycle.

    Raises
    ------
    TypeError
        The count is no integer.
    ValueError
        The count is out of range.
    """

    def __init__(self, *, layout: StructLayout, count: int, urgent: int | None = None):
        check_integer("Count", count, minimum=1)
        self._urgent = urgent
        super().__init__({"i": In(stream.Signature(layout, always_ready=True)).array(count), "clear": In(1),
                          "o": Out(layout)})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        # What is latched next, and whether something is, do not wait for the clear: it only enables.
        fault, holds = Signal.like(self.o), Signal()
        for source in reversed(list(self.i)):
            with m.If(source.valid):
                m.d.comb += fault.eq(source.payload)
        comes, first = Value.cast(fault.code) != 0, self.i[0]
        is_urgent = first.valid & (Value.cast(first.payload.code) == self._urgent) if self._urgent else 0
        with m.If(self.clear | (comes & ~holds) | is_urgent):
            m.d.sync += [self.o.eq(fault), holds.eq(comes)]
        return m
