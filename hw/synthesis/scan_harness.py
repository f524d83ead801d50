"""A component between shift registers, so that one with any number of ports fits the pins of a chip."""

from amaranth.hdl import Cat, ClockDomain, ClockSignal, Const, Elaboratable, Instance, Module, Mux, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

__all__ = ["ScanHarness"]


class ScanHarness(wiring.Component):
    """Every input bit comes from a register, every output bit goes to one: paths of ports count like all others.

    The reset is that of the chip, an ECP5, which takes no wires: so it is on the board too.

    Parameters
    ----------
    component
        The component inside.

    Members
    -------
    clk, rst
        Clock and reset of all.
    i
        Next bit for the inputs.
    capture
        Take in all outputs; otherwise they move on towards ``o``.
    o
        Last bit of the outputs.
    input_bits, output_bits
        Registers of the harness itself, to be taken off a count.

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
        self.input_bits, self.output_bits = len(self._inputs), len(self._outputs)

    def elaborate(self, platform):
        m = Module()
        m.domains.sync = ClockDomain(reset_less=True)
        m.submodules.component = self._component
        m.submodules.reset = Instance("SGSR", i_CLK=self.clk, i_GSR=~self.rst)
        given, taken = Signal(self.input_bits), Signal(self.output_bits)
        m.d.comb += [ClockSignal().eq(self.clk), self._inputs.eq(given), self.o.eq(taken[-1])]
        m.d.sync += [given.eq(Cat(self.i, given)), taken.eq(Mux(self.capture, self._outputs, Cat(0, taken)))]
        return m
