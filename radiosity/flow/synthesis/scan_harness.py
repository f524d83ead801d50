"""A component between registers that are loaded and read by shifting: any number of ports fits the pins of a chip."""

from amaranth.hdl import Cat, ClockDomain, ClockSignal, Const, Elaboratable, Instance, Module, Mux, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

__all__ = ["ScanHarness"]


class ScanHarness(wiring.Component):
    """Every input bit comes from a register, and every output bit ends in one, so that paths of ports are timed too.
    The shift registers are separate: the placer puts neighbours in a shift register close together, and would pull the
    component's ports with them.

    The reset is the global one of the ECP5 (``SGSR``), which needs no routing, as on the board.

    Parameters
    ----------
    component
        The component inside.

    Members
    -------
    clk, rst : In(1)
        Clock and reset.
    i : In(1)
        Next bit of the inputs' shift register.
    capture : In(1)
        Capture all outputs of the cycle before; otherwise they are shifted towards ``o``.
    o : Out(1)
        Last bit of the outputs' shift register.

    Timing
    ------
    One bit per cycle.
    """

    clk: In(1)
    rst: In(1)
    i: In(1)
    capture: In(1)
    o: Out(1)

    def __init__(self, component: Elaboratable):
        super().__init__()
        self._component = component
        ports = [(member, Value.cast(value)) for _, member, value in component.signature.flatten(component)]
        ports = [(member, value) for member, value in ports if not isinstance(value, Const)]
        self._inputs = Cat(value for member, value in ports if member.flow is In)
        self._outputs = Cat(value for member, value in ports if member.flow is Out)

    def elaborate(self, platform):
        m = Module()
        m.domains.sync = ClockDomain(reset_less=True)
        m.submodules.component = self._component
        m.submodules.reset = Instance("SGSR", i_CLK=self.clk, i_GSR=~self.rst)
        shifted, given = Signal(len(self._inputs)), Signal(len(self._inputs))
        captured, taken = Signal(len(self._outputs)), Signal(len(self._outputs))
        m.d.comb += [ClockSignal().eq(self.clk), self._inputs.eq(given), self.o.eq(captured[-1])]
        m.d.sync += [shifted.eq(Cat(self.i, shifted)), given.eq(shifted), taken.eq(self._outputs),
                     captured.eq(Mux(self.capture, taken, Cat(0, captured)))]
        return m
