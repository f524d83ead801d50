"""No `ready` that a unit of a cluster or of the engine gives depends on another unit's in the same cycle.

The netlist of each is searched: of the cluster with all that it holds, of the engine with clusters as black boxes.
What the lint must find is shown by units of a test's own, and by the machine without one of its skid buffers.
"""

import pytest
from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

import hw.engine
from golden.engine.config import PRESETS
from hw.cluster import Cluster
from hw.engine import Engine
from hw.lib.skid_buffer import SkidBuffer
from hw.memsys.bus.local_bus import LocalBus
from tb.system.connections import IdleUnit
from tb.system.ready_paths import is_unit, ready_paths

# With lists of subshells; small otherwise.
CONFIG = PRESETS["board"].replace({"ctu.subshell_bits": 6, "noc.patch_nodes": 0})

# The sink and the source of each `ready` that depends on another unit's nevertheless, with the reason.
KNOWN = {
    "cluster": {
        ("results.i", "intersection.i_read_out"): "once per section; a read-out begins when its section is accepted"},
    "engine": {
        ("control.i_refused", "completions.i_record"): "once per refused descriptor; it counts when it is recorded"},
}
KNOWN["engine with a patch node"] = KNOWN["engine"]
# Blocks of the engine, for the control.
IDLE = ("Registers", "JobControl", "MainMemoryPort", "CompletionWriter", "DescriptorFetch", "JobDispatch", "PreloadDma",
        "WriteMerge", "LocalBus", "SystemBusInterface", "PatchNetwork", "Cluster")
MAKERS = {"cluster": lambda: Cluster(config=CONFIG), "engine": lambda: Engine(config=CONFIG, black_boxes=True),
          "engine with a patch node": lambda: Engine(config=PRESETS["board"], black_boxes=True)}


class Wire(wiring.Component):
    """Has the ports of a skid buffer, and no register."""

    def __init__(self, shape):
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape))})

    def elaborate(self, platform):
        m = Module()
        wiring.connect(m, wiring.flipped(self.i), wiring.flipped(self.o))
        return m


class Chain(wiring.Component):
    """Two wires in a row, with or without a skid buffer in between."""

    def __init__(self, *, is_registered):
        self._is_registered = is_registered
        super().__init__({"i": In(stream.Signature(4)), "o": Out(stream.Signature(4))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.first, m.submodules.second = first, second = Wire(4), Wire(4)
        between = first.o
        wiring.connect(m, wiring.flipped(self.i), first.i)
        if self._is_registered:
            m.submodules.between = buffer = SkidBuffer(4)
            wiring.connect(m, first.o, buffer.i)
            between = buffer.o
        wiring.connect(m, between, second.i)
        wiring.connect(m, second.o, wiring.flipped(self.o))
        return m


class Bypass(wiring.Component):
    """A wire as a unit, and a stream that goes around it."""

    def __init__(self):
        super().__init__({"i": In(stream.Signature(4)), "o": Out(stream.Signature(4)),
                          "i_beside": In(stream.Signature(4)), "o_beside": Out(stream.Signature(4))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.unit = unit = Wire(4)
        wiring.connect(m, wiring.flipped(self.i), unit.i)
        wiring.connect(m, unit.o, wiring.flipped(self.o))
        wiring.connect(m, wiring.flipped(self.i_beside), wiring.flipped(self.o_beside))
        return m


def _is_wire(component):
    return isinstance(component, Wire)


def _idle(real):
    return lambda *given, **named: IdleUnit(real(*given, **named).signature)


def _ends_of_the_engine():
    paths = ready_paths(Engine(config=CONFIG), is_unit=lambda unit: is_unit(unit) or isinstance(unit, IdleUnit))
    return {path.ends for path in paths}


@pytest.mark.parametrize("name", [
    pytest.param(name, marks=[pytest.mark.sim] * (name != "engine")) for name in MAKERS])
def test_no_ready_depends_on_another_units(name):
    """Exactly the known ones do: one that is no longer there must leave the list."""
    found = ready_paths(MAKERS[name]())
    assert {path.ends for path in found} == KNOWN[name].keys(), "\n".join(map(str, found))


def test_two_wires_in_a_row_are_found():
    found = {path.ends: path for path in ready_paths(Chain(is_registered=False), is_unit=_is_wire)}
    assert found.keys() == {("first.i", "second.i"), ("second.i", "o")}
    assert "first.i.ready depends on second.i.ready" in str(found["first.i", "second.i"])
    assert "o__ready" in found["first.i", "second.i"].steps


def test_a_skid_buffer_cuts_the_path():
    found = {path.ends for path in ready_paths(Chain(is_registered=True), is_unit=_is_wire)}
    assert found == {("second.i", "o")}


def test_a_path_around_all_units_is_found_and_one_through_a_unit_is_its_own():
    assert {path.ends for path in ready_paths(Bypass(), is_unit=_is_wire)} == {
        ("unit.i", "o"), ("i_beside", "o_beside")}


@pytest.mark.sim
def test_the_engine_without_a_skid_buffer_is_found(monkeypatch):
    """Between the load, which is the only block that is not idle, and the clusters: each word waits for all of them."""
    for name in IDLE:
        monkeypatch.setattr(hw.engine, name, _idle(getattr(hw.engine, name)))
    assert not _ends_of_the_engine()
    monkeypatch.setattr(hw.engine, "SkidBuffer", Wire)
    assert _ends_of_the_engine() == {("load.i_word", f"cluster_{number}.i_word") for number in range(CONFIG.noc.nodes)}


def test_buffers_and_forks_are_no_units():
    assert not is_unit(SkidBuffer(4))
    assert is_unit(LocalBus(config=CONFIG, clusters=1))
