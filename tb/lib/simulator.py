"""Amaranth's own simulator, as all benches use it."""

from amaranth.sim import Simulator

from hw.lib.checks import checked
from tb.lib.collisions import with_collisions

__all__ = ["simulator_of"]


def simulator_of(component, *benches, period: float | None = 1e-8) -> Simulator:
    """A simulator in which the claims of all components are checked (`hw.lib.checks`) and collisions of memories show.

    Parameters
    ----------
    component
        The component, or a module.
    benches
        Testbenches.
    period
        Seconds of a cycle of ``sync``; None: clocks are added by the caller, or there are none.
    """
    with checked():
        simulator = Simulator(with_collisions(component))
    if period is not None:
        simulator.add_clock(period)
    for bench in benches:
        simulator.add_testbench(bench)
    return simulator
