"""The rules of streams, as assertions about any component."""

from collections.abc import Callable

from amaranth.hdl import Assert, Assume, Const, Cover, Module, Signal, Value
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out

__all__ = ["add_rules", "ready_blind", "stream_rules"]


def _streams_of(component) -> list[tuple[bool, object]]:
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
    """An offer stays unchanged until it is accepted; there is none right after a reset.

    Parameters
    ----------
    m
        Where the rules go.
    interface
        A stream.
    check
        ``Assert`` of an output of a component, ``Assume`` of an input. The names of the assertions are
        "withdrawn", "changed" and "after reset".
    """
    payload = Value.cast(interface.payload)
    waited, after_reset, before = Signal(), Signal(init=1), Signal.like(payload)
    m.d.sync += [waited.eq(interface.valid & ~interface.ready), after_reset.eq(0), before.eq(payload)]
    with m.If(waited):
        m.d.comb += [check(interface.valid, "withdrawn"), check(payload == before, "changed")]
    with m.If(after_reset):
        m.d.comb += check(~interface.valid, "after reset")


def stream_rules(m, bench, dut):
    """All output streams of a component keep the rules if all its input streams do.

    Covers an item that stalls on each of the outputs.
    """
    for gives, interface in _streams_of(dut):
        add_rules(m, interface, Assert if gives else Assume)
        if gives and not interface.signature.always_ready:
            m.d.comb += Cover(interface.valid & ~interface.ready, "waits")


def ready_blind(m, bench, dut, copy):
    """``valid`` does not depend on ``ready`` of the same cycle.

    A copy of the component has the same inputs, until ``ready`` of one stream differs in one cycle.
    """
    m.submodules.copy = copy
    given, copied = ([interface for gives, interface in _streams_of(one)
                      if gives and not interface.signature.always_ready] for one in (dut, copy))
    differs, differed = bench.free(len(given), "differs"), Signal()
    m.d.sync += differed.eq(differed | differs.any())
    mine, bits = {path: Value.cast(value) for path, _, value in dut.signature.flatten(dut)}, iter(differs)
    for path, member, value in copy.signature.flatten(copy):
        value = Value.cast(value)
        if member.flow is In and not isinstance(value, Const):
            m.d.comb += value.eq(mine[path] ^ next(bits) if path[-1] == "ready" else mine[path])
    for k, (one, other) in enumerate(zip(given, copied, strict=True)):
        with m.If(~differed & (differs == 1 << k)):
            m.d.comb += [Assert(one.valid == other.valid, "blind"), Cover(one.valid, "offers")]
