"""The streams and the plain ports of a component, by name."""

from collections.abc import Iterator

from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

__all__ = ["payload_shape", "port_flows", "port_patterns", "ports_of", "stream_of", "streams_of"]

_STREAM = {"payload", "valid", "ready"}


def streams_of(signature: wiring.Signature) -> dict[wiring.Flow, list[str]]:
    """Names of the streams in and out; those of an array are called ``NAME__0`` and so on."""
    found = {In: [], Out: []}
    for name, member in _members(signature):
        if member.is_signature and set(member.signature.members) == _STREAM:
            found[member.flow].append(name)
    return found


def ports_of(signature: wiring.Signature) -> dict[str, object]:
    """Shapes of the plain ports; those of an interface are called ``NAME__PORT``."""
    return {name: member.shape for name, member in _ports(signature)}


def port_flows(signature: wiring.Signature) -> dict[str, wiring.Flow]:
    """Directions of the plain ports."""
    return {name: member.flow for name, member in _ports(signature)}


def port_patterns(signature: wiring.Signature) -> tuple[str, ...]:
    """Patterns of the names that clock, reset and all members have in Verilog."""
    return ("clk", "rst", *(pattern for name, member in signature.members.items()
                            for pattern in ([f"{name}__*"] if member.is_signature or member.dimensions else [name])))


def payload_shape(signature: wiring.Signature, name: str):
    """The shape of a stream's payload."""
    return signature.members[name.partition("__")[0]].signature.members["payload"].shape


def stream_of(component, name: str):
    """The stream of a name in a component."""
    found = component
    for part in name.split("__"):
        found = found[int(part)] if part.isdigit() else getattr(found, part)
    return found


def _members(signature) -> Iterator[tuple[str, wiring.Member]]:
    for name, member in signature.members.items():
        if len(member.dimensions) == 1:
            yield from ((f"{name}__{number}", member) for number in range(member.dimensions[0]))
        elif not member.dimensions:
            yield name, member


def _ports(signature) -> Iterator[tuple[str, wiring.Member]]:
    for name, member in _members(signature):
        if member.is_port:
            yield name, member
        elif set(member.signature.members) != _STREAM:
            inner = member.signature if member.flow is Out else member.signature.flip()
            yield from ((f"{name}__{port}", one) for port, one in inner.members.items() if one.is_port)
