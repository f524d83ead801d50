"""Checks in components: they end a simulation at the first violation, and no export has them."""

import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from hw.lib.checks import checked, claim
from hw.lib.credit_gate import CreditGate
from radiosity.flow.verilog.export import verilog_of


class Small(wiring.Component):
    """Its input is below 3."""

    def __init__(self):
        super().__init__({"a": In(2), "o": Out(2)})

    def elaborate(self, platform):
        """The claim."""
        m = Module()
        m.d.sync += self.o.eq(self.a)
        claim(m, self.a != 3, "a is below 3")
        return m


def violated(component, drive, *, is_checked=True):
    """Whether a check ends the simulation."""
    async def bench(ctx):
        for values in drive:
            for port, value in values:
                ctx.set(port, value)
            await ctx.tick()

    with checked(is_checked):
        simulator = Simulator(component)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    try:
        simulator.run()
    except AssertionError:
        return True
    return False


@pytest.mark.parametrize("values", [(0, 2, 1), (0, 3, 0)])
def test_a_simulation_ends_where_a_claim_does_not_hold(values):
    small = Small()
    assert violated(small, [[(small.a, value)] for value in values]) == (3 in values)
    small = Small()
    assert not violated(small, [[(small.a, value)] for value in values], is_checked=False)


@pytest.mark.parametrize("returns", [1, 2])
def test_a_credit_that_returns_twice_is_found(returns):
    gate = CreditGate(4, credits=2)
    item = [(gate.i.valid, 1), (gate.o.ready, 1)]
    back = [(gate.i.valid, 0), (gate.i_return.valid, 1)]
    assert violated(gate, [item, *[back] * returns, [(gate.i_return.valid, 0)]]) == (returns > 1)


def test_no_export_has_checks_unless_it_is_for_a_simulation():
    with checked():
        assert "assert" not in verilog_of(CreditGate(4, credits=2), "top")
    assert "assert" in verilog_of(CreditGate(4, credits=2), "top", is_checked=True)
