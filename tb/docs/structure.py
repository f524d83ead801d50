"""What a component is made of, read from its code: ports, submodules, memories, and what goes from one to another."""

import gc
import importlib
import inspect
import pkgutil
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from types import MappingProxyType
from unittest import mock

from amaranth.hdl import ClockSignal, Elaboratable, Fragment, Module, ResetSignal, Shape, Value
from amaranth.hdl._ast import Operator, SignalDict, SignalSet
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, Layout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In

import hw
from golden.base.without_collection import without_collection

__all__ = [
    "SELF", "Block", "Field", "Link", "Port", "Store", "Structure", "component_classes", "fields_of", "structures"]

# The block of a link that is the component's own port.
SELF = ""


@dataclass(frozen=True)
class Field:
    """A part of a payload."""

    name: str
    bits: int


@dataclass(frozen=True)
class Port:
    """A stream, a signal, or an interface of several signals.

    ``path`` names it: ``i``, ``o[1]``, ``host``. ``kind`` is "stream", "signal" or "interface"; ``always_ready`` is of
    streams.
    """

    path: str
    is_input: bool
    kind: str
    bits: int
    fields: tuple[Field, ...]
    always_ready: bool = False


@dataclass(frozen=True)
class Block:
    """A submodule that is a component."""

    name: str
    cls: type


@dataclass(frozen=True)
class Store:
    """A memory; those of pipelines have no names."""

    name: str | None
    depth: int
    bits: int


@dataclass(frozen=True)
class Link:
    """What comes out of a block's port goes into another one's, as it is or changed on the way.

    Blocks and ports are named; `SELF` is the component that holds them.
    """

    source: str
    source_port: str
    sink: str
    sink_port: str
    kind: str


@dataclass(frozen=True)
class Structure:
    """A component in a certain configuration."""

    cls: type
    latency: int | None
    ports: tuple[Port, ...]
    blocks: tuple[Block, ...]
    stores: tuple[Store, ...]
    links: tuple[Link, ...]


def component_classes() -> dict[str, type]:
    """All components of `hw` by module and name."""
    found = {}
    for info in pkgutil.walk_packages(hw.__path__, "hw."):
        if info.name.endswith("__main__"):
            continue
        module = importlib.import_module(info.name)
        for name in getattr(module, "__all__", ()):
            value = getattr(module, name)
            if inspect.isclass(value) and issubclass(value, wiring.Component) and value.__module__ == info.name:
                found[f"{info.name}.{name}"] = value
    return found


def structures(makers: Iterable, *, whole: bool = True, has_links: bool = True,
               stands_for: Mapping[type, type] = MappingProxyType({})) -> dict[type, Structure]:
    """Look at components.

    Parameters
    ----------
    makers
        Functions that make a component each.
    whole
        Look at what they are made of too, one component of each class.
    has_links
        Look at what goes from one to another, which takes most of the time.
    stands_for
        Classes of submodules that are there instead of others.

    Returns
    -------
    dict
        By class.
    """
    found: dict[type, Structure] = {}
    with _quiet(), without_collection(), _shallow() as elaborate:
        for make in makers:
            waiting = [make()]
            while waiting:
                component = waiting.pop(0)
                if type(component) in found:
                    continue
                children, found[type(component)] = _look_at(component, elaborate, stands_for, has_links)
                if whole:
                    waiting += children
        waiting = children = component = None
    return found


@contextmanager
def _quiet():
    """In which components may be left without being elaborated."""
    with mock.patch.object(Elaboratable, "_MustUse__silence", True):
        yield
        # What was left goes here, not where it would be reported.
        gc.collect()


@contextmanager
def _shallow():
    """A function that elaborates a component as if nothing were in its submodules."""
    originals = {cls: cls.elaborate for cls in component_classes().values()}

    def stub(self, platform):
        # The component that is being looked at, or one below it.
        return originals[type(self)](self, platform) if self is looked_at[0] else Module()

    def elaborate(component):
        looked_at[0] = component
        return Fragment.get(component, None)

    looked_at = [None]
    with ExitStack() as stack:
        for cls in originals:
            stack.enter_context(mock.patch.object(cls, "elaborate", stub))
        yield elaborate
    looked_at[0] = None


def _look_at(component, elaborate, stands_for, has_links):
    """Components of its submodules, and its structure."""
    fragment = elaborate(component)
    blocks, stores, parts = [], [], {SELF: component}
    for part, name, *_ in fragment.subfragments:
        for origin in part.origins or ():
            if isinstance(origin, Memory):
                stores.append(Store(name, origin.depth, Shape.cast(origin.shape).width))
            elif isinstance(origin, wiring.Component):
                blocks.append(Block(name, stands_for.get(type(origin), type(origin))))
                parts[name] = origin
    links = tuple(sorted(_links(fragment, parts) if has_links else (), key=lambda one: (
        list(parts).index(one.source), list(parts).index(one.sink), one.kind, one.source_port, one.sink_port)))
    return [part for name, part in parts.items() if name != SELF], Structure(
        type(component), getattr(component, "latency", None), tuple(_ports(component)), tuple(blocks),
        tuple(stores), links)


def _ports(component) -> Iterator[Port]:
    """What a component shows; of arrays of ports each."""
    for path, is_input, kind, signature, _ in _flat_ports(component):
        if kind == "stream":
            yield Port(path, is_input, kind, Shape.cast(signature.members["payload"].shape).width,
                       fields_of(signature.members["payload"].shape), signature.always_ready)
        elif kind == "signal":
            yield Port(path, is_input, kind, Shape.cast(signature.shape).width, fields_of(signature.shape))
        else:
            fields = tuple(Field(".".join(map(str, names)), Shape.cast(member.shape).width)
                           for names, member, _ in signature.flatten(signature.create()))
            yield Port(path, is_input, kind, sum(field.bits for field in fields), fields)


def _flat_ports(component) -> Iterator[tuple]:
    """Path, direction, kind, signature (of a signal its member) and value of each port."""

    def walk(path, member, value, dimensions):
        if dimensions:
            for number in range(dimensions[0]):
                yield from walk(f"{path}[{number}]", member, value[number], dimensions[1:])
        elif member.is_port:
            yield path, member.flow is In, "signal", member, value
        else:
            signature = member.signature
            plain = signature.flip() if isinstance(signature, wiring.FlippedSignature) else signature
            is_stream = isinstance(plain, stream.Signature)
            yield path, member.flow is In, "stream" if is_stream else "interface", plain, value

    for name, member in component.signature.members.items():
        yield from walk(name, member, getattr(component, name), member.dimensions)


def fields_of(shape) -> tuple[Field, ...]:
    """The parts of a payload, those of parts by a point."""
    def walk(shape, path):
        if isinstance(shape, ArrayLayout):
            yield Field(f"{path}[{shape.length}]" if path else f"[{shape.length}]", Shape.cast(shape).width)
        elif isinstance(shape, Layout):
            for key, field in shape:
                yield from walk(field.shape, f"{path}.{key}" if path else str(key))
        else:
            yield Field(path, Shape.cast(shape).width)

    return tuple(walk(shape, "")) if isinstance(shape, Layout) else ()


def _links(fragment, parts) -> set[Link]:
    """From statements: what a port's value is made of, through signals of the component's own."""
    gives, takes = SignalDict(), []
    at_once, later = _drivers(fragment)
    for name, part in parts.items():
        for path, is_input, kind, signature, value in _flat_ports(part):
            if kind == "interface":
                # Named by what the one who starts transfers drives.
                leaves = [leaf for _, member, leaf in signature.flatten(value) if member.flow is not In]
                ways = [(leaf, later) for leaf in leaves]
            elif kind == "stream":
                # An offer may come from elsewhere than what it carries; a register in between makes it another one.
                ways = [(value.payload, later), (value.valid, at_once)]
            else:
                ways = [(value, later)]
            # A component's own inputs are sources for what is in it.
            if is_input == (name == SELF):
                for leaf, _ in ways:
                    _note(gives, leaf, (name, path, kind))
                if kind == "stream":
                    _note(gives, value.ready, None)
            else:
                takes += [(name, path, kind, leaf, drivers) for leaf, drivers in ways]
    links = set()
    for name, path, kind, value, drivers in takes:
        for source, source_port, source_kind in _sources(Value.cast(value), gives, drivers):
            links.add(Link(source, source_port, name, path, kind if kind == source_kind else "signal"))
    return links


def _note(gives, value, what):
    for signal in Value.cast(value)._rhs_signals():
        gives[signal] = what


def _drivers(fragment) -> tuple[SignalDict, SignalDict]:
    """The signals that each signal is assigned from, in the same cycle and in any; conditions do not count."""

    def walk(statements, drivers):
        for statement in statements:
            if hasattr(statement, "cases"):
                for case in statement.cases:
                    walk(case[1], drivers)
            elif hasattr(statement, "lhs"):
                for signal in statement.lhs._lhs_signals():
                    drivers.setdefault(signal, SignalSet())
                    drivers[signal].update(_read(statement.rhs))

    at_once, later = SignalDict(), SignalDict()
    walk(fragment.statements.get("comb", ()), at_once)
    for statements in fragment.statements.values():
        walk(statements, later)
    return at_once, later


def _read(value):
    """The signals of an expression, without clocks and resets of domains."""
    if isinstance(value, ClockSignal | ResetSignal):
        return SignalSet()
    if isinstance(value, Operator):
        return SignalSet(signal for operand in value.operands for signal in _read(operand))
    return value._rhs_signals()


def _sources(value, gives, drivers):
    """Where a value comes from."""
    seen, waiting, found = SignalSet(), list(value._rhs_signals()), set()
    while waiting:
        for driver in drivers.get(waiting.pop(), ()):
            if driver in gives:
                if gives[driver] is not None:
                    found.add(gives[driver])
            elif driver not in seen:
                seen.add(driver)
                waiting.append(driver)
    return found
