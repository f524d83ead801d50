"""What the parts of a cluster's path to patches of others are compared by: their outcomes, means and areas."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.istructure import SIZES, outcomes_of, relative, sized_cycles
from benchmarks.path_area import equal_area_table, path_area
from benchmarks.report import tables_of
from benchmarks.shared_hardware import recorded_rows, simulated_rows
from benchmarks.shared_scene import Access, Placement, SharedScene, shared_config
from golden.engine.config import PRESETS
from radiosity.flow.synthesis.history import ROOT, last_records, read_history
from radiosity.machines.engine.job_latencies import joint_timing

RAYS, CLUSTERS, SHARE = (16, 8), 2, "1/4"


@cache
def lobby():
    return SharedScene("lobby", rays=RAYS, cell=1)


@cache
def found():
    return outcomes_of(lobby(), CLUSTERS, (SHARE,))


@pytest.fixture
def scene():
    return lobby()


@pytest.fixture
def outcomes(interpreted):
    return found()


def test_every_patch_has_one_source(scene, outcomes):
    for (placement, _, access), one in outcomes.items():
        others = one.kept + one.remote + one.hits + one.misses
        assert one.own + others == outcomes[Placement.EVERYWHERE, "all", Access.DEFERRAL].own
        assert (others > 0) == (placement is not Placement.EVERYWHERE)
        assert access.has_store or not one.kept + one.deferred
        assert access is not Access.MEMORY or not one.remote + one.flits


def test_paths_differ_in_cycles_and_not_in_what_they_fetch(outcomes):
    for placement in Placement.DEALT, Placement.DISCOVERY:
        deferral, blocking, single = (outcomes[placement, SHARE, access] for access in (
            Access.DEFERRAL, Access.BLOCKING, Access.SINGLE))
        assert replace(blocking, cycles=0, hits=0, misses=0) == replace(deferral, cycles=0, hits=0, misses=0)
        assert deferral.deferred > 0
        assert max(deferral.cycles, blocking.cycles) < single.cycles


def test_flits_are_those_of_packets_at_each_router(outcomes):
    """Two routers send a packet between neighbours."""
    timing = joint_timing(shared_config(CLUSTERS, RAYS))
    one = outcomes[Placement.DEALT, SHARE, Access.NETWORK]
    assert one.flits == 2 * (timing.request_flits + timing.reply_flits) * one.remote > 0


def test_dealt_sets_hold_a_share_in_each_cluster(scene):
    home = scene.home(CLUSTERS, Placement.DEALT, 1 / 4)
    held = [np.count_nonzero(home[0] == cluster) for cluster in (-1, *range(CLUSTERS))]
    share = -(-scene.patches // 4)
    assert held == [scene.patches - 2 * share, share, share]


def test_paper_has_memory_for_the_largest_scene_whose_copies_are_smaller_than_a_network():
    smaller = [row["patches"] for row in tables_of(equal_area_table())[0]["rows"]
               if row["all, in block RAMs"] < row["1/8 and network"]]
    assert smaller == [256 << step for step in range(len(smaller))]
    assert PRESETS["paper"].memsys.own_patches == smaller[-1]


def test_sizes_are_those_of_resident_sets_and_stores(scene, outcomes, monkeypatch):
    monkeypatch.setattr("benchmarks.istructure.SIZES", ((57, 32), (57, 2), (256, 32)))
    stored, single, whole = sized_cycles(scene, CLUSTERS)
    # A quarter of the scene, an eighth in the store.
    assert stored == outcomes[Placement.DEALT, SHARE, Access.DEFERRAL].cycles
    assert whole == outcomes[Placement.EVERYWHERE, "all", Access.DEFERRAL].cycles
    assert single != stored


def test_the_page_has_the_areas_of_two_sizes():
    large, small = (path_area(own, frames=frames, access=Access.DEFERRAL, clusters=1)[1] for own, frames in SIZES[1:])
    assert f"The former takes {large} block RAMs, the latter {small}." in (ROOT / "docs" / "istructure.md").read_text()


def test_areas_are_those_of_the_parts_of_a_path():
    deferral, single, network, memory = (np.array(path_area(100, frames=128, access=access, clusters=4)) for access in (
        Access.DEFERRAL, Access.SINGLE, Access.NETWORK, Access.MEMORY))
    last = last_records(read_history())
    interface, router = (last["ecp5", "paper", "", "noc", unit] for unit in ("NetworkInterface", "Router-72-2"))
    assert (network - memory).tolist() == [interface.lut + 2 * router.lut, interface.bram + 2 * router.bram]
    assert (deferral > single).all()
    assert (single > network).all()
    assert path_area(100, frames=128, access=Access.NETWORK, clusters=1) == tuple(memory)


@pytest.mark.nightly
def test_simulated_cycles_are_those_of_the_hardware():
    error = {row: abs(simulated / row.cycles - 1) for row, simulated in simulated_rows(recorded_rows())}
    assert len(error) == 18
    assert max(error.values()) < 0.03


def test_a_mean_is_geometric(outcomes):
    half = {key: replace(one, cycles=one.cycles if key[0] is Placement.EVERYWHERE else one.cycles / 2)
            for key, one in outcomes.items()}
    first, second, mean = (relative(each, Placement.DEALT, SHARE, Access.MEMORY) for each in (
        [outcomes], [half], [outcomes, half]))
    assert np.isclose(second, first / 2)
    assert np.isclose(mean, np.sqrt(first * second))
