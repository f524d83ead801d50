"""Combinational paths between the `ready` of one unit and the `ready` of another one, found in the netlist.

Amaranth's own netlist is searched, not that of a synthesis: it knows which nets a port is, and which line made a cell.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from amaranth.hdl import Const, Fragment, Value
from amaranth.hdl._ir import NetlistEmitter, PortDirection
from amaranth.hdl._nir import Netlist
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

import hw

__all__ = ["ReadyPath", "is_unit", "ready_paths"]

_ROOT = Path(hw.__file__).parent.parent


@dataclass(frozen=True)
class ReadyPath:
    """A `ready` that depends on another unit's in the same cycle.

    ``sink`` is the `ready` that a unit gives, ``source`` the other unit's: ``memory.i_cell``. A port of the component
    itself has no unit in front. ``steps`` are the signals and the lines of the cells from source to sink.
    """

    sink: str
    source: str
    steps: tuple[str, ...]

    @property
    def ends(self) -> tuple[str, str]:
        """The two streams."""
        return self.sink, self.source

    def __str__(self):
        return f"{self.sink}.ready depends on {self.source}.ready: {', '.join(self.steps) or 'a wire'}"


def is_unit(component: wiring.Component) -> bool:
    """Whether a component directly inside of what is checked is a unit.

    Those of `hw.lib` and of Amaranth are not: a skid buffer, a queue, an arbiter or a fork belongs to the stream that
    it is in.
    """
    return type(component).__module__.startswith("hw.") and not type(component).__module__.startswith("hw.lib.")


def ready_paths(component: wiring.Component, *, is_unit: Callable = is_unit) -> list[ReadyPath]:
    """Each `ready` that a unit gives, and those of other units and of the surroundings that it depends on at once.

    Parameters
    ----------
    component
        The units are submodules of it. What stands outside of it counts as one unit more.
    is_unit
        Whether a submodule is a unit.

    Returns
    -------
    list
        Of each pair of streams a shortest path. A path ends at the first unit that it meets.
    """
    design = Fragment.get(component, None).prepare(ports=list(_pins(component)), hierarchy=("top",))
    netlist = Netlist()
    NetlistEmitter(netlist, design, all_undef_to_ff=False).emit_fragment(design.fragment, None)
    units = {name: unit for fragment, name, _ in design.fragment.subfragments for unit in fragment.origins or ()
             if isinstance(unit, wiring.Component) and is_unit(unit)}
    # The unit that receives a stream gives its `ready`; the surroundings give those of the streams that leave.
    given = {net: (name, f"{name}.{path}") for name, unit in units.items()
             for path, net in _readies(netlist, unit, receives=True)}
    sources = given | {net: ("", path) for path, net in _readies(netlist, component, receives=False)}
    sinks = given | {net: (None, path) for path, net in _readies(netlist, component, receives=True)}
    found = []
    for net, (owner, sink) in sinks.items():
        ends = {end: source for end, (other, source) in sources.items() if other != owner}
        # The component gives what its units give: of its own streams only paths around all units count.
        found += [ReadyPath(sink, ends[end], steps) for end, steps in _paths(netlist, net, ends)
                  if owner is not None or not sources[end][0]]
    return found


def _pins(component):
    """The ports of a component, with directions, as Amaranth's conversion takes them."""
    for names, member, value in component.signature.flatten(component):
        if not isinstance(value, Const):
            direction = PortDirection.Input if member.flow is In else PortDirection.Output
            yield "__".join(map(str, names)), Value.cast(value), direction


def _readies(netlist, component, *, receives) -> Iterator[tuple]:
    """Name and net of the `ready` of each stream that a component receives, or sends."""
    for names, member, value in component.signature.flatten(component):
        if names[-1] != "ready" or isinstance(value, Const) or (member.flow is Out) != receives:
            continue
        if value in netlist.signals:
            path = "".join(f"[{name}]" if isinstance(name, int) else f".{name}" for name in names[:-1])
            yield path[1:], netlist.signals[value][0]


def _paths(netlist, start, ends) -> Iterator[tuple]:
    """Ends that a net depends on without a register in between, with the steps from there."""
    via, waiting = {start: None}, [start]
    for net in waiting:
        if net in ends:
            yield net, _steps(via, net)
            continue
        for source, step in _sources(netlist, net):
            if source not in via:
                via[source] = net, step
                waiting.append(source)


def _sources(netlist, net):
    """The nets that a net depends on in the same cycle, each with the signal or the line in between."""
    if net.is_late:
        yield netlist.connections[net], netlist.late_to_signal[net][0].name
    elif not net.is_const:
        # A register depends on its clock and on an asynchronous reset.
        for source, (file, line) in netlist.cells[net.cell].comb_edges_to(net.bit):
            path = Path(file)
            yield source, f"{path.relative_to(_ROOT) if _ROOT in path.parents else path.name}:{line}"


def _steps(via, net):
    steps = []
    while via[net]:
        net, step = via[net]
        steps.append(step)
    return tuple(step for number, step in enumerate(steps) if number == 0 or step != steps[number - 1])
