"""Steps of refinement: golden's hits and sums, and the traffic of patches."""

from functools import lru_cache
from itertools import islice

import numpy as np
import pytest

from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.shelling import Shelling
from golden.engine.config import PRESETS
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.open import open_scene
from radiosity.machines.paper.paper_step import simulate_steps
from radiosity.machines.paper.prepared_step import prepare_steps
from radiosity.machines.paper.supply import Supply
from tb.radiosity.machines.paper.timings import TIMING, changed

CONFIG = PRESETS["paper"].replace({"memsys.own_patches": 256})
HEMISPHERE = Hemisphere(64, 16)


@lru_cache
def prepared():
    """Two steps of two frusta, on four clusters."""
    return tuple(islice(prepare_steps(open_scene("lobby"), CONFIG, cell=0.125, hemisphere=HEMISPHERE, order=2,
                                      clusters=4, units=8, ratio=16), 2))


@lru_cache
def simulated(supply):
    return simulate_steps(prepared(), CONFIG, TIMING, supply=supply)


def test_hits_are_golden_s():
    scene = open_scene("lobby")
    shelling = Shelling(PatchGeometry.of(scene, CONFIG.numbers), CONFIG, cell=0.125)
    for step in prepared():
        for frustum in step.frusta:
            assert not len(shelling.cast(frustum.record)[0].differences(frustum.hits))


def test_a_step_has_a_source_and_a_schedule_of_its_own():
    first, second = prepared()
    scene = open_scene("lobby")
    assert scene.channels("emission")[first.source].any()
    assert first.source != second.source
    assert not np.array_equal(first.plan.partition.cluster_map, second.plan.partition.cluster_map)


@pytest.mark.parametrize("supply", Supply)
def test_intensities_at_the_host_are_golden_s_sums(supply):
    for step in simulated(supply):
        for frustum, merged in zip(step.prepared.frusta, step.sums, strict=True):
            hit = frustum.hits.patch >= 0
            sums = np.zeros(227, dtype=np.int64)
            np.add.at(sums, frustum.hits.patch[hit], HEMISPHERE.weights[hit])
            assert np.array_equal(merged.patch, np.flatnonzero(sums))
            assert np.array_equal(merged.sum, sums[merged.patch])


@pytest.mark.parametrize("supply", Supply)
def test_a_step_ends_with_the_last_message(supply):
    for step in simulated(supply):
        assert step.cycles == max(merged.time[-1] for merged in step.sums)
        assert step.cycles > max(one.ends[-1] for one in step.counts)


@pytest.mark.parametrize("supply", Supply)
def test_each_reference_has_a_level(supply):
    for step in simulated(supply):
        found = [sum(frustum.works[cluster].patches for frustum in step.prepared.frusta) for cluster in range(4)]
        for counts, memory, patches in zip(step.counts, step.memories, found, strict=True):
            assert counts.patches == memory.residents + memory.hits + memory.misses
            assert counts.patches + counts.skipped == patches
        assert step.replies == sum(memory.misses for memory in step.memories)


def test_levels_are_those_of_the_supply():
    pushed, pulled, main = (simulated(supply)[0] for supply in (Supply.PUSHED, Supply.PULLED, Supply.MAIN))
    assert all(memory.residents and memory.hits for memory in pushed.memories)
    assert not any(memory.residents for memory in (*pulled.memories, *main.memories))
    assert sum(memory.hits for memory in pulled.memories)
    assert not any(memory.hits for memory in main.memories)
    assert sum(one.skipped for one in pushed.counts) == sum(one.skipped for one in main.counts) > 0
    assert not any(one.skipped for one in pulled.counts)
    assert pushed.replies < main.replies
    assert pushed.cycles < min(pulled.cycles, main.cycles)


def test_a_patch_that_clusters_hold_is_not_pushed_again():
    steps = simulated(Supply.PUSHED)
    for before, step in zip((None, *steps), steps, strict=False):
        lacking = set()
        for cluster, own in enumerate(step.prepared.plan.resident):
            held = set(before.prepared.plan.resident[cluster].tolist()) if before else set()
            lacking |= set(own.tolist()) - held
        assert step.pushed == len(lacking)
    assert steps[1].pushed < len(set().union(*(own.tolist() for own in steps[1].prepared.plan.resident)))


def test_a_pushed_patch_leaves_the_root_once():
    """Tags take a cycle each, patches their words."""
    step = simulated(Supply.PUSHED)[0]
    assert step.root_cycles == step.prepared.plan.tags.sent.sum() + TIMING.words * (step.pushed + step.replies)
    assert sum(map(len, step.prepared.plan.resident)) > step.pushed
    assert sum(len(memory.held) for memory in step.memories) == sum(map(len, step.prepared.plan.resident))


def test_main_memory_has_its_latency():
    slow = simulate_steps(prepared()[:1], CONFIG, changed(main=400), supply=Supply.MAIN)
    assert slow[0].cycles > 1.5 * simulated(Supply.MAIN)[0].cycles
