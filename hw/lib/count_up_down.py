"""Counts of what is in a buffer or in flight."""

from amaranth.hdl import Mux, Signal, ValueLike

from hw.lib.checks import claim_steps

__all__ = ["count_up_down"]


def count_up_down(m, count: Signal, *, up: ValueLike, down: ValueLike, most: int) -> None:
    """Step a register: one up, one down, or not at all if both come in the same cycle or neither does.

    Parameters
    ----------
    m
        The component's module.
    count
        The register, in ``sync``. Nothing keeps it in its range: ``up`` must not come at its end, nor ``down`` at 0.
    up, down
        One bit each.
    most
        The end of the range.
    """
    claim_steps(m, count, up=up, down=down, most=most)
    with m.If(up ^ down):
        m.d.sync += count.eq(count + Mux(up, 1, -1))
