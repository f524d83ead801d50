"""Negative controls: components with one known fault, for which a proof must fail."""

from collections.abc import Callable

from amaranth.hdl import Module
from amaranth.lib import wiring

from tb.formal.connect_ports import connect_ports

__all__ = ["NegativeControl"]


class NegativeControl(wiring.Component):
    """A component of which some outputs are wrong.

    Parameters
    ----------
    dut
        The component.
    faults
        From the name of an output to a function of the component, its wrong value; see `connect_ports`.

    Members
    -------
    Those of the component, whose other attributes it has too.
    """

    def __init__(self, dut, faults: dict[str, Callable]):
        self._dut, self._faults = dut, faults
        super().__init__(dut.signature)
        # Constants and shapes that the rules refer to.
        for name, value in vars(dut).items():
            if not hasattr(self, name):
                setattr(self, name, value)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = self._dut
        connect_ports(m, self, self._dut, self._faults)
        return m
