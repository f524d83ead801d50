"""Connections from a wrapper's ports to those of the component inside."""

from collections.abc import Callable

from amaranth.hdl import Const, Module, Value
from amaranth.lib.wiring import In

__all__ = ["connect_ports"]


def connect_ports(m: Module, wrapper, component, overrides: dict[str, Callable] | None = None) -> None:
    """Connect a wrapper's ports to the component's ports of the same names; the wrapper may have further ports.

    Parameters
    ----------
    m
        The wrapper's module.
    wrapper, component
        The outer and the inner component.
    overrides
        From the name of an output, like ``o__valid``, to a function of the inner component; the wrapper's output has
        its value instead of the component's.

    Raises
    ------
    ValueError
        There is no output of such a name.
    """
    overrides = dict(overrides or {})
    ports = {path: Value.cast(value) for path, _, value in wrapper.signature.flatten(wrapper)}
    for path, member, value in component.signature.flatten(component):
        outer, inner = ports[path], Value.cast(value)
        if isinstance(inner, Const):
            continue
        if member.flow is In:
            m.d.comb += inner.eq(outer)
        else:
            override = overrides.pop("__".join(str(part) for part in path), None)
            m.d.comb += outer.eq(inner if override is None else override(component))
    if overrides:
        raise ValueError(f"Output must be one of the component's, not {', '.join(overrides)}")
