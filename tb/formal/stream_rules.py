"""The rules of streams, as assertions about any component."""

from collections.abc import Callable

from amaranth.hdl import Assert, Assume, Const, Cover, Module, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tb.formal.connect_ports import connect_ports

__all__ = ["ReadyBlind", "StreamRules", "add_rules", "streams_of"]


def streams_of(component) -> list[tuple[bool, object]]:
    """Each stream among a component's ports: whether the component gives it, and the interface."""
    found = []
    for name, member in component.signature.members.items():
        if member.is_signature and isinstance(member.signature, stream.Signature):
            ports = [getattr(component, name)]
            for _ in member.dimensions:
                ports = [port for several in ports for port in several]
            found.extend((member.flow is Out, port) for port in ports)
    return found


def add_rules(m: Module, interface, check: Callable) -> None:
    """What is offered is offered unchanged until it is taken; nothing is offered right after a reset.

    Parameters
    ----------
    m
        Where the rules go.
    interface
        A stream.
    check
        ``Assert`` of a stream that a component gives, ``Assume`` of one that it takes.
    """
    payload = Value.cast(interface.payload)
    waited, after_reset, before = Signal(), Signal(init=1), Signal.like(payload)
    m.d.sync += [waited.eq(interface.valid & ~interface.ready), after_reset.eq(0), before.eq(payload)]
    with m.If(waited):
        m.d.comb += [check(interface.valid), check(payload == before)]
    with m.If(after_reset):
        m.d.comb += check(~interface.valid)


class StreamRules(wiring.Component):
    """All streams that a component gives keep the rules if all that it takes do. Every input is free.

    Covers an item on each of them that waits.

    Parameters
    ----------
    dut
        The component.
    """

    def __init__(self, dut):
        self._dut = dut
        super().__init__(dut.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = self._dut
        connect_ports(m, self, self._dut)
        for gives, interface in streams_of(self):
            add_rules(m, interface, Assert if gives else Assume)
            if gives and not interface.signature.always_ready:
                m.d.comb += Cover(interface.valid & ~interface.ready)
        return m


class ReadyBlind(wiring.Component):
    """Whether a component offers an item does not depend on whether it is taken in the same cycle.

    Two copies are given the same, until for once ``ready`` of one stream differs.

    Parameters
    ----------
    dut, copy
        The component twice.
    """

    def __init__(self, dut, copy):
        self._dut, self._copy = dut, copy
        self._given = [interface for gives, interface in streams_of(dut)
                       if gives and not interface.signature.always_ready]
        super().__init__({**dict(dut.signature.members.items()), "differs": In(len(self._given))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut, m.submodules.copy = self._dut, self._copy
        connect_ports(m, self, self._dut)
        differed, differs = Signal(), iter(self.differs)
        m.d.sync += differed.eq(differed | self.differs.any())
        mine = {path: Value.cast(value) for path, _, value in self._dut.signature.flatten(self._dut)}
        for path, member, value in self._copy.signature.flatten(self._copy):
            value = Value.cast(value)
            if member.flow is In and not isinstance(value, Const):
                m.d.comb += value.eq(mine[path] ^ next(differs) if path[-1] == "ready" else mine[path])
        copied = [interface for gives, interface in streams_of(self._copy)
                  if gives and not interface.signature.always_ready]
        for k, (one, other) in enumerate(zip(self._given, copied, strict=True)):
            with m.If(~differed & (self.differs == 1 << k)):
                m.d.comb += Assert(one.valid == other.valid)
        return m
