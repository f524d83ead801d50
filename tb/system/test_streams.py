"""What comes out of a block depends on what goes in, not on when, and an offer stays until it is taken.

Every block that a configuration alone describes gets random items on its streams: once as fast as it takes them, then
with gaps, in which the payload is garbage, and stalls. Its other inputs are constant.
"""

import inspect
import random

import pytest
from amaranth.hdl import Const, Value, unsigned
from amaranth.lib.wiring import In
from amaranth.sim import Simulator

from golden.engine.config import PRESETS
from tb.docs.structure import component_classes

CONFIG = PRESETS["tiny"].replace({"ctu.subshell_bits": 10, "noc.columns": 2, "noc.rows": 1})
FOLDERS = ("lib", "control", "memsys", "ctu", "icu", "noc")
GIVEN = {"config": CONFIG, "tag": unsigned(4), "shape": unsigned(7)}
# Their simulation takes seconds; they have testbenches with stalls, and most of their parts are below.
LARGE = {"MemorySystem", "IntersectionUnit", "TraversalUnit", "CellTraversal", "RayTraversal", "SubshellGenerator",
         "CtRayGenerator", "PatchNetwork", "SystemBusInterface", "PatchSetup", "SphericalCoordinates", "Sbb",
         "SubshellWindows", "UvSubdivision", "UvAlignment", "TraversalStart", "PlaneFactor"}
# Of certain structures or configurations only; without a clock.
OTHERS = {"GroupSplit", "ListReadOut", "RayList", "SectionReadOut", "TableLoad"}
# Probabilities of an offer and of readiness, and cycles.
FAST, SLOW = (1, 1, 400), ((0.5, 0.5, 200), (0.9, 0.3, 200))


COMPONENTS = {}
for _path, _kind in component_classes().items():
    _needed = {name for name, one in inspect.signature(_kind).parameters.items()
               if one.default is inspect.Parameter.empty}
    if _path.split(".")[1] in FOLDERS and _needed <= GIVEN.keys() and _kind.__name__ not in LARGE | OTHERS:
        COMPONENTS[_kind.__name__] = _kind, {name: GIVEN[name] for name in _needed}

# What another stream stores is read whenever it comes, or requests and answers that belong together are drawn apart.
TIMED = {
    "CellSteps": {"o"}, "CompletionWriter": {"o_data"}, "FrustumSlot": {"o", "o_near"}, "GridEntries": {"o"},
    "IcRayGenerator": {"o"}, "ImageHeader": {"o"}, "LoadControl": {"o_word"}, "LocalBusInterface": {"o_request"},
    "NearCellBanks": {"o"}, "NearWindow": {"o"}, "PatchExtents": {"o"}, "PatchSlots": {"o"}, "RayMemory": {"o_read"},
    "ReadEngine": {"o_fault"}, "RowArcs": {"o"}, "SettleMap": {"o_read", "o_walk"}, "SubshellTable": {"o"},
    "WriteEngine": {"o_fault"}}
# Answers, words and ends that nothing has requested change them.
UNREQUESTED = {"CompletionWriter": {"o_data", "o_request"}, "FrustumSlot": {"o"}, "JobControl": {"o_record"},
               "LoadControl": {"o_word"}, "LoadState": {"o"}}
# No item is compared: those of one run at least want answers, tables or numbers that are not drawn.
SILENT = {
    "BeatWriter": {"o_data", "o_request"}, "EdgePlanes": {"o", "o_planes"}, "FrustumLoad": {"o_subshell"},
    "InverseDistanceBound": {"o"}, "JobControl": {"o_load", "o_record"},
    "JobDispatch": {"o", "o_load", "o_refused", "o_sent"}, "LoadControl": {"o_command"},
    "PatchNode": {"o_remote"}, "PatchSums": {"o"}, "PreloadDma": {"o"},
    "RowPieces": {"o"}, "SectionCast": {"o_results"}, "SettleSweep": {"o_0", "o_1", "o_tile"}, "VertexGate": {"o"}}


def _leaves(signature, obj, name=""):
    """Streams and other ports by name, with whether they are inputs."""
    for member, what in signature.members.items():
        yield from _elements(what, getattr(obj, member), f"{name}{member}", what.dimensions)


def _elements(what, value, name, dimensions):
    if dimensions:
        for index in range(dimensions[0]):
            yield from _elements(what, value[index], f"{name}[{index}]", dimensions[1:])
    elif what.is_port or {"payload", "valid", "ready"} <= set(what.signature.members):
        yield name, what.flow == In, value
    else:
        yield from _leaves(what.signature, value, f"{name}.")


class Runs:
    """Runs of a component, each from its initial state; its simulator is made once.

    Members
    -------
    moved
        Streams whose offer changed before it was taken, in any run.
    """

    def __init__(self, kind, given):
        self._dut = kind(**given)
        self._inputs, self._outputs, self._others = {}, {}, {}
        for name, is_input, value in _leaves(self._dut.signature, self._dut):
            if hasattr(value, "payload") and hasattr(value, "ready"):
                (self._inputs if is_input else self._outputs)[name] = (
                    Value.cast(value.payload), value.valid, value.ready)
            elif is_input:
                self._others[name] = Value.cast(value)
        self._came, self.moved = None, set()
        # Without claims: neighbours promise more than random items keep.
        self._simulator = Simulator(self._dut)
        self._simulator.add_clock(1e-8)
        self._simulator.add_testbench(self._run)

    def run(self, *, offers, takes, cycles):
        """Items of each stream, for probabilities of an offer and of readiness."""
        self._offers, self._takes, self._cycles = offers, takes, cycles
        if self._came is not None:
            self._simulator.reset()
        self._came = {name: [] for name in self._outputs}
        self._simulator.run()
        return self._came

    async def _run(self, ctx):
        when, what = random.Random(self._offers), {name: random.Random(name) for name in self._inputs}
        for name, signal in self._others.items():
            ctx.set(signal, random.Random(name).getrandbits(len(signal)))
        items = {name: what[name].getrandbits(256) for name in self._inputs}
        offered, held = set(), {}
        for _ in range(self._cycles):
            for name, (payload, valid, _ready) in self._inputs.items():
                if when.random() < self._offers:
                    offered.add(name)
                ctx.set(valid, name in offered)
                ctx.set(payload, (items[name] if name in offered else when.getrandbits(256)) % (1 << len(payload)))
            for _payload, _valid, ready in self._outputs.values():
                if not isinstance(ready, Const):
                    ctx.set(ready, when.random() < self._takes)
            taken = [name for name in offered if ctx.get(self._inputs[name][2])]
            for name, (payload, valid, ready) in self._outputs.items():
                item = ctx.get(payload) if ctx.get(valid) else None
                if name in held and item != held[name]:
                    self.moved.add(name)
                held.pop(name, None)
                if item is not None and ctx.get(ready):
                    self._came[name].append(item)
                elif item is not None:
                    held[name] = item
            for name in taken:
                offered.remove(name)
                items[name] = what[name].getrandbits(256)
            await ctx.tick()


def _found(name):
    """Streams whose items depend on time, those whose offers do not stay, and those of which no item is compared."""
    kind, given = COMPONENTS[name]
    runs = Runs(kind, given)
    fast, *slow = (runs.run(offers=offers, takes=takes, cycles=cycles) for offers, takes, cycles in (FAST, *SLOW))
    timed = {name for came in slow for name, items in came.items()
             if any(a != b for a, b in zip(items, fast[name], strict=False))}
    silent = {name for name, items in fast.items() if not items or not any(came[name] for came in slow)}
    return timed, runs.moved, silent


@pytest.mark.sim
@pytest.mark.parametrize("name", COMPONENTS)
def test_items_do_not_depend_on_gaps_stalls_and_garbage_and_offers_stay(name):
    timed, moved, silent = _found(name)
    assert timed <= TIMED.get(name, set())
    assert moved <= UNREQUESTED.get(name, set())
    assert silent == SILENT.get(name, set())


def test_exceptions_are_of_components():
    assert TIMED.keys() | UNREQUESTED.keys() | SILENT.keys() <= COMPONENTS.keys()
