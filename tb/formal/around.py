"""Ports of a bench around a component's."""

from collections.abc import Callable

from amaranth.hdl import Const, Module, Value
from amaranth.lib.wiring import In

__all__ = ["connect_ports"]


def connect_ports(m: Module, outside, inside, instead: dict[str, Callable] | None = None) -> None:
    """Put a component into one that has the same ports, perhaps among others.

    Parameters
    ----------
    m
        The outer one's module.
    outside, inside
        The components.
    instead
        From the name of an output of the outer one, like ``o__valid``, to what it is instead of the inner one's: a
        function of the inner component.

    Errors
    ------
    ValueError
        There is no output of such a name.
    """
    instead = dict(instead or {})
    ports = {path: Value.cast(value) for path, _, value in outside.signature.flatten(outside)}
    for path, member, value in inside.signature.flatten(inside):
        outer, inner = ports[path], Value.cast(value)
        if isinstance(inner, Const):
            continue
        if member.flow is In:
            m.d.comb += inner.eq(outer)
        else:
            change = instead.pop("__".join(str(part) for part in path), None)
            m.d.comb += outer.eq(inner if change is None else change(inside))
    if instead:
        raise ValueError(f"Output must be one of the component's, not {', '.join(instead)}")
