"""A whole schedule on real scenes: its predictions hold, and it changes no hit."""

from dataclasses import replace

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.screen import Screen
from golden.engine.frustum import screen_record
from golden.engine.schedule.low_density import low_density
from golden.engine.schedule.phase import schedule
from golden.engine.schedule.subshells import subshell_lists
from golden.engine.schedule.usage import cumulative_frequency
from golden.scene.open import open_scene
from tb.golden.engine.schedule.scenes import CONFIG, case

SCENES = ["room1627", *(pytest.param(name, marks=pytest.mark.nightly) for name in ("cubes", "phone"))]
CAPACITY = 512


@pytest.fixture(scope="module", params=SCENES)
def scene(request):
    return case(request.param)


def made(scene, **options):
    options = {"clusters": 8, "ratio": 16, **options}
    return schedule(scene.record, scene.geometry, scene.shelling.table, CONFIG, **options)


def test_patches_are_found_once_and_shell_by_shell(scene):
    found = made(scene).found
    assert len(np.unique(found.patches)) == len(found.patches)
    assert (np.diff(found.shell) >= 0).all()
    assert np.array_equal(np.sort(found.patches), np.flatnonzero(found.frequency))


def test_all_other_patches_fill_the_free_entries(scene):
    plain, filled = made(scene, capacity=CAPACITY), made(scene, capacity=CAPACITY, fill=True)
    found, passed = plain.found.patches, filled.found.passed
    assert not np.intersect1d(found, passed).size
    assert len(np.unique(passed)) == len(passed)
    for held, more in zip(plain.sets.patches, filled.sets.patches, strict=True):
        assert more[:len(held)].tolist() == held.tolist()
        assert len(more) <= CAPACITY
    residents = np.concatenate(filled.sets.patches)
    assert len(np.unique(residents)) == len(residents)
    assert len(residents) == min(len(scene.geometry), 8 * CAPACITY) > len(plain.sets)
    # Those that rays may meet come before the others.
    assert np.isin(np.concatenate([found, passed])[:8 * CAPACITY], residents).mean() == 1
    # What a casting is given is more often resident.
    references = np.zeros(len(scene.geometry), dtype=np.int64)
    scene.shelling.cast(scene.record, references=references)
    assert references[residents].sum() >= references[plain.sets.chosen].sum()


def test_what_is_filled_has_a_size(scene):
    with pytest.raises(InputError, match="Capacity must be given where sets are filled, not None"):
        made(scene, fill=True)


def test_work_by_frustum_and_by_patch_are_the_same_work(scene):
    found = made(scene).found
    assert found.tests.sum() == found.frequency.sum()


def test_cell_steps_are_shared_out_and_none_is_lost(scene):
    _, (counts,) = scene.shelling.cast(scene.record)
    plan = made(scene, ratio=1)
    assert plan.estimated_steps.sum() == pytest.approx(round(plan.found.steps.sum()))
    assert 0.7 < plan.found.steps.sum() / counts.cell_steps < 1.5


def test_all_rays_cast_estimate_the_work_of_a_dense_casting(scene):
    table = scene.shelling.table
    references = np.zeros(len(scene.geometry), dtype=np.int64)
    scene.shelling.cast(scene.record, references=references)
    found = low_density(scene.record, scene.geometry, table, CONFIG, ratio=1)
    assert 0.7 < found.tests.sum() / references.sum() < 1.3
    # Windows are larger than patches, so some patches behind them are missed.
    assert cumulative_frequency(references, found.patches) > 0.8


def test_the_estimate_balances_the_true_work_better_than_equal_sections(scene):
    def balance(sections):
        tests = np.array([counts.tests for counts in scene.shelling.cast(scene.record, sections)[1]])
        return tests.max() / tests.mean()

    plan = made(scene)
    assert plan.estimated.max() / plan.estimated.mean() < 1.1
    equal = made(scene, ray_capacity=len(scene.record) // 8)
    assert balance(plan.partition.sections) < balance(equal.partition.sections)


def test_a_plan_without_subshells_has_all_else(scene):
    plan = made(scene)
    bare = plan.without_subshells()
    assert sum(map(len, (listed.patches for listed in plan.subshells))) > 0
    assert not any(len(listed.patches) or len(listed.shell) for listed in bare.subshells)
    assert len(bare.subshells) == len(plan.subshells)
    assert bare.sets is plan.sets
    assert bare.partition is plan.partition


def test_subshells_are_resident_patches_in_order_and_none_is_redundant(scene):
    plan = made(scene)
    for held, subshells in zip(plan.sets.patches, plan.subshells, strict=True):
        indices = [held.tolist().index(patch) for patch in subshells.patches]
        assert indices == sorted(indices)
        assert (np.diff(subshells.shell) >= 0).all()


def test_subshells_take_each_frustum_to_each_shell_once(scene):
    plan = made(scene)
    for sector, subshells in zip(plan.partition.sections, plan.subshells, strict=True):
        version = np.zeros(plan.found.frusta.shape, dtype=int)
        for patch, shell in zip(subshells.patches, subshells.shell, strict=True):
            overlap = plan.found.frusta.overlaps(plan.found.window[np.flatnonzero(plan.found.patches == patch)])
            column, row = overlap.column * plan.found.frusta.width, overlap.row * plan.found.frusta.height
            inside = (column < sector.end_column) & (column + plan.found.frusta.width > sector.first_column) \
                & (row < sector.end_row) & (row + plan.found.frusta.height > sector.first_row)
            reached = np.zeros(version.shape, dtype=bool)
            reached[overlap.row[inside], overlap.column[inside]] = True
            assert (reached & (version < shell)).any(), "each subshell explores what no earlier one has"
            version[reached] = shell


def test_the_subshell_list_of_everything_starts_with_the_first_patch_found():
    scene = case("room1627")
    plan = made(scene, clusters=1)
    (subshells,) = subshell_lists(plan.found, plan.sets, plan.partition)
    assert subshells.patches[0] == plan.found.patches[0]


def test_a_patch_that_is_not_resident_defines_no_subshell():
    plan = made(case("room1627"), capacity=3)
    assert max(len(held) for held in plan.sets.patches) == 3
    for held, subshells in zip(plan.sets.patches, plan.subshells, strict=True):
        assert set(subshells.patches) <= set(held)


def test_a_topology_moves_clusters_to_other_processors_and_nothing_else():
    scene = case("room1627")
    plain, near = made(scene), made(scene, topology="mesh")
    assert plain.processor.tolist() == list(range(8))
    assert sorted(near.processor) == list(range(8))
    assert np.array_equal(plain.cluster, near.cluster)


def test_a_screen_is_scheduled_too():
    room = open_scene("room1627")
    scene = case("room1627")
    record = screen_record(Screen(camera=room.camera, width=90, height=50), scene.geometry.coordinates)
    plan = made(replace(scene, record=record), ratio=64)
    whole, _ = scene.shelling.cast(record)
    cut, counts = scene.shelling.cast(record, plan.partition.sections)
    assert not len(whole.differences(cut))
    tests = np.array([count.tests for count in counts])
    assert tests.max() / tests.mean() < 2
