"""Black box: stands for a component that is a separately built module."""

from collections.abc import Iterator, Mapping

from amaranth.hdl import ClockSignal, Const, Instance, Module, ResetSignal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In

__all__ = ["BlackBox", "flatten"]


def flatten(component: wiring.Component) -> Iterator[tuple[str, wiring.Member, Value]]:
    """Names, members and values of all ports, except for those that have no bits or are constant."""
    for path, member, value in component.signature.flatten(component):
        value = Value.cast(value)
        if len(value) and not isinstance(value, Const):
            yield "__".join(map(str, path)), member, value


class BlackBox(wiring.Component):
    """The interface of a component around an instance of a Verilog module of a given name.

    All instances share the module, which is generated and compiled once.

    Parameters
    ----------
    members
        Of the component.
    name
        Of its module.

    Members
    -------
    Those of the component.
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
