"""Apart: a component that is exported on its own, and placed by its name."""

from collections.abc import Iterator, Mapping

from amaranth.hdl import ClockSignal, Const, Instance, Module, ResetSignal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In

__all__ = ["Apart", "flatten"]


def flatten(component: wiring.Component) -> Iterator[tuple[str, wiring.Member, Value]]:
    """Names, members and values, without such as have no bits and such as are always the same."""
    for path, member, value in component.signature.flatten(component):
        value = Value.cast(value)
        if len(value) and not isinstance(value, Const):
            yield "__".join(map(str, path)), member, value


class Apart(wiring.Component):
    """Has the interface of a component; inside there is an instance of the module of that name.

    Many of them share one module, so that it is made, and compiled, once.

    Parameters
    ----------
    members
        Of the component.
    name
        Of its module.
    """

    def __init__(self, members: Mapping, *, name: str):
        self._name = name
        super().__init__(dict(members))

    def elaborate(self, platform):
        m = Module()
        ports = {"i_clk": ClockSignal(), "i_rst": ResetSignal()}
        for path, member, value in flatten(self):
            ports[f"{'i' if member.flow is In else 'o'}_{path}"] = value
        m.submodules.placed = Instance(self._name, **ports)
        return m
