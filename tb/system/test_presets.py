"""All presets are elaborated: what is connected is as wide at both ends, every tag has its bits, and all parts of the
machine are there.

Simulations of a commit have few clusters, where a tag that is a bit too narrow is as wide as it must be.
"""

from contextlib import contextmanager

import pytest
from amaranth.hdl import Fragment, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import PRESETS
from golden.engine.config.parts import parts
from hw.cluster import Cluster
from hw.ctu.cell_traversal import CellTraversal
from hw.engine import Engine
from hw.icu.intersection_pipeline import IntersectionPipeline
from hw.memsys.bus.cache import Cache
from hw.memsys.memory_system import MemorySystem
from hw.memsys.patches.istructure import IStructure
from hw.memsys.patches.local_patch_geometry import LocalPatchGeometry
from hw.noc.router import Router
from tb.system import truncations as module
from tb.system.truncations import truncations

# These take fields from words of memory, and narrow sums and products whose other bits are known.
FIELDS = {f"hw/{folder}/{name}.py" for folder, names in {
    "control": ("descriptor_fetch", "frustum_load", "frustum_slot", "job_control", "job_dispatch",
        "load_control"),
    "ctu": ("ct_ray_generator", "near_window", "row_arcs", "stage_rows", "subshell_generator"),
    "icu": ("edge_planes", "inverse_distance_bound", "patch_sums", "ray_direction", "sbb"),
    "lib": ("generations", "pipeline"),
    "memsys/bus": ("cell_fetch", "patch_decoder", "system_bus_interface"),
    "memsys/load": ("image_header", "preload_dma", "table_load"),
    "memsys/patches": ("cell_table", "filter", "local_bus_interface", "local_patch_geometry", "patch_table",
        "patch_type_memory"),
    "memsys/port": ("burst_splitter",),
    "noc": ("unpacker",),
    "registers": ("registers",),
}.items() for name in names}


# What a part is made of.
PARTS = {"cell traversal": {CellTraversal}, "intersection pipeline": {IntersectionPipeline},
         "resident set and caches": {LocalPatchGeometry, Cache}, "I-structure": {IStructure}, "router": {Router}}


@contextmanager
def elaborated():
    """The classes of `PARTS` that are elaborated meanwhile."""
    found = set()
    with pytest.MonkeyPatch.context() as patch:
        for cls in set().union(*PARTS.values()):
            def elaborate(self, platform, *, cls=cls, make=cls.elaborate):
                found.add(cls)
                return make(self, platform)

            patch.setattr(cls, "elaborate", elaborate)
        yield found


# A commit has the one with all units but the store; the others are in `make sim`.
@pytest.mark.parametrize("preset", [
    pytest.param(preset, marks=[pytest.mark.sim] * (preset != "thesis")) for preset in PRESETS])
def test_no_bit_is_lost_unsaid_and_no_part_is_missing(preset):
    config = PRESETS[preset]
    with elaborated() as built:
        found = truncations(Engine(config=config, black_boxes=True), Cluster(config=config))
    assert {name: lines for name, lines in found.items() if name not in FIELDS} == {}
    assert found.keys() >= FIELDS, "files that lose no bits any more"
    assert built == set().union(*(PARTS[part.name] for part in parts(config) if part.size))


@pytest.mark.parametrize(("preset", "changes"), [*((preset, {}) for preset in PRESETS), ("tiny", {
    "noc.columns": 1, "noc.rows": 1}), ("tiny", {"memsys.store_patches": 0})])
def test_a_cluster_has_the_store_that_its_configuration_names(preset, changes):
    config = PRESETS[preset].replace(changes)
    with elaborated() as built:
        Fragment.get(MemorySystem(config=config), None)
    (about,) = (part.about for part in parts(config) if part.name == "I-structure")
    assert (IStructure in built) == ("wait in the patch store" in about) == (config.memsys.store_patches > 0)


class Narrow(wiring.Component):
    """Loses a bit of a port, with or without saying so, and a number that has more bits than its tag."""

    def __init__(self, *, says):
        self._says = says
        super().__init__({"i": In(4), "o": Out(3), "is_last": Out(1)})

    def elaborate(self, platform):
        m = Module()
        count = Signal(3)
        m.d.sync += count.eq(count + 1)
        value, last = (self.i[:3], 7) if self._says else (self.i, 8)
        m.d.comb += [self.o.eq(value), self.is_last.eq(count == last)]
        return m


@pytest.mark.parametrize("says", [False, True])
def test_a_lost_bit_and_a_number_out_of_range_are_found(says, monkeypatch):
    """A wrapping counter is none."""
    monkeypatch.setattr(module, "_SOURCES", module._ROOT / "tb")
    found = truncations(Narrow(says=says))
    assert [len(lines) for lines in found.values()] == ([] if says else [2])
