"""Checks of a component's own rules, for simulations and proofs, and counters with theirs; an export has no checks."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from amaranth.hdl import Assert, Const, Module, Mux, ResetSignal, Signal, Value, ValueLike

__all__ = ["checked", "claim", "claim_steps", "count_entries", "count_steps", "count_up_down", "entries_in_use",
           "has_checks"]

# What is in use, of the components that are elaborated with their checks; None without checks.
_entries = ContextVar("entries", default=None)


@contextmanager
def checked(is_checked: bool = True) -> Iterator[None]:
    """A context in which components are elaborated with their checks, or without them, as by default."""
    token = _entries.set([] if is_checked else None)
    try:
        yield
    finally:
        _entries.reset(token)


def has_checks() -> bool:
    """Whether components are elaborated with their checks."""
    return _entries.get() is not None


def claim(m: Module, holds: ValueLike, message: str) -> None:
    """Claim what holds in each cycle but those of the domain's reset: a simulation ends where it does not.

    Parameters
    ----------
    m
        The component's module.
    holds
        One bit, of registers and inputs in ``sync``.
    message
        The rule.
    """
    if has_checks():
        m.d.sync += Assert(holds | ResetSignal("sync", allow_reset_less=True), message)


def claim_steps(m: Module, count: Value, *, up: ValueLike, down: ValueLike, most: int) -> None:
    """Claim that a register counts from 0 to ``most`` and never wraps.

    Parameters
    ----------
    m
        The component's module.
    count
        The register.
    up, down
        By how many it steps in this cycle.
    most
        The end of its range.
    """
    after = count + up - down
    claim(m, (after >= 0) & (after <= most), f"{count.name} stays from 0 to {most}")


def count_steps(m: Module, count: Signal, *, up: ValueLike, down: ValueLike, most: int) -> None:
    """Step a register: ``count + up - down``. Parameters as of `count_up_down`, but for steps of any size."""
    claim_steps(m, count, up=up, down=down, most=most)
    m.d.sync += count.eq(count + up - down)


def count_up_down(m: Module, count: Signal, *, up: ValueLike, down: ValueLike, most: int) -> None:
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


def count_entries(used: ValueLike) -> None:
    """Count the entries of a buffer that are in use, or the credits that are spent: none while nothing is in flight."""
    if has_checks():
        _entries.get().append(Value.cast(used))


def entries_in_use() -> Value:
    """The sum of `count_entries` over all components that have been elaborated in this context."""
    return Value.cast(sum(_entries.get(), Const(0, 1)))
