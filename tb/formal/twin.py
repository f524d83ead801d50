"""Broken twins: components with a fault, of which a proof must fail."""

from collections.abc import Callable

from amaranth.hdl import Module
from amaranth.lib import wiring

from tb.formal.around import connect_ports

__all__ = ["Twin"]


class Twin(wiring.Component):
    """A component of which some outputs are wrong.

    Parameters
    ----------
    dut
        The component.
    faults
        From the name of an output to what it is instead, see `connect_ports`.
    """

    def __init__(self, dut, faults: dict[str, Callable]):
        self._dut, self._faults = dut, faults
        super().__init__(dut.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = self._dut
        connect_ports(m, self, self._dut, self._faults)
        return m
