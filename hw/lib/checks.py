"""Checks of a component's own rules, for simulations and proofs; an export has none."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from amaranth.hdl import Assert, Module, ResetSignal, ValueLike

__all__ = ["checked", "claim"]

_is_checked = ContextVar("is_checked", default=False)


@contextmanager
def checked(is_checked: bool = True) -> Iterator[None]:
    """A context in which components are elaborated with their checks, or without them, as by default."""
    token = _is_checked.set(is_checked)
    try:
        yield
    finally:
        _is_checked.reset(token)


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
    if _is_checked.get():
        m.d.sync += Assert(holds | ResetSignal("sync", allow_reset_less=True), message)
