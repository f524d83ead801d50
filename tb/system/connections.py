"""A component around units that do nothing but what a test lets them do."""

import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring

from tb.lib.simulator import simulator_of

__all__ = ["Connections", "IdleUnit"]


class IdleUnit(wiring.Component):
    """The ports of a unit, given its signature; it does nothing."""

    def elaborate(self, platform):
        """Nothing."""
        return Module()


class Connections:
    """A component around units that do nothing; it is elaborated once.

    Parameters
    ----------
    module, names
        The module of the component, and the units in it.
    make
        Constructs the component.

    Members
    -------
    dut, units
        The component, and its units by name, the last one of several.
    """

    def __init__(self, module, names, make):
        self.units, self._bench = {}, None
        with pytest.MonkeyPatch.context() as patch:
            for name in names:
                patch.setattr(module, name, self._replaced(name, getattr(module, name)))
            self.dut = make()
            self._simulator = simulator_of(self.dut, self._run)

    def _replaced(self, name, real):
        def make(*given, **named):
            made = real(*given, **named)
            unit = self.units[name] = IdleUnit(made.signature)
            # Of the real unit latencies are used too.
            vars(unit).update({key: value for key, value in vars(made).items() if isinstance(value, int)})
            return unit

        return make

    async def _run(self, ctx):
        await self._bench(ctx)

    def simulate(self, bench):
        """Run a testbench from reset on."""
        if self._bench:
            self._simulator.reset()
        self._bench = bench
        self._simulator.run()
