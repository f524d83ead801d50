"""What the host requests: whole frusta, or even shares of them; schedules only where they are needed."""

from dataclasses import replace

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.screen import Screen
from golden.engine.cast.shelling import Shelling
from golden.engine.frustum import screen_record
from golden.engine.jobs.frustum_cycles import frustum_cycles
from golden.engine.jobs.job import plan_job
from golden.engine.jobs.phase_request import phase_request, sections_per_frustum
from golden.engine.jobs.result_formats import HitFormat
from golden.scene.open import open_scene
from tb.golden.engine.cast.drawn_shadows import drawn_frustum
from tb.golden.engine.jobs.jobs import CONFIG, RAYS, hemispheres, scene


def request(records, config, **given):
    return phase_request(records, scene().geometry, scene().shelling.table, config, ratio=16, **given)


@pytest.mark.parametrize(("frusta", "clusters", "shared"), [
    (1, 1, 1), (9, 1, 1), (1, 4, 8), (2, 4, 4), (3, 4, 8), (4, 4, 1), (5, 4, 1), (6, 8, 8), (8, 16, 4), (12, 16, 8)])
def test_each_cluster_has_the_same_number_of_sections(frusta, clusters, shared):
    assert sections_per_frustum(frusta, clusters) == shared
    assert frusta >= clusters or frusta * shared % (2 * clusters) == 0


def test_frusta_that_fill_the_machine_are_not_scheduled(monkeypatch):
    monkeypatch.setattr("golden.engine.jobs.phase_request.machine_schedule", None)
    monkeypatch.setattr("golden.engine.jobs.phase_request.low_density", None)
    made = request(hemispheres(2), CONFIG, weights=RAYS.polar_weights, hit_format=HitFormat.COMPACT, sums=True)
    assert (made.clusters, made.plan, made.workload) == (1, None, None)
    assert (made.hit_format, made.sums, made.weights.tolist()) == (HitFormat.COMPACT, True, RAYS.polar_weights.tolist())


def test_cycles_are_predicted_where_clusters_take_frusta_in_turn():
    alone = CONFIG.replace({"noc.columns": 1, "noc.rows": 1})
    beside = CONFIG.replace({"noc.patch_nodes": 1})
    assert [request(hemispheres(count), config).cycles for count, config in (
        (2, CONFIG), (3, alone), (3, beside))] == [None] * 3
    table = scene().shelling.table
    np.testing.assert_array_equal(request(hemispheres(3), CONFIG).cycles, frustum_cycles(
        hemispheres(3), scene().geometry, table, CONFIG))


def test_a_single_frustum_is_cut_by_expected_work():
    config = CONFIG.replace({"icu.rays": 1024})
    assert request(hemispheres(1), config).clusters == 4
    made = request(hemispheres(1), config, clusters=2)
    assert (made.clusters, made.plan) == (2, None)
    first, second = (one.section for one in plan_job([made], config).sections if one)
    work = [made.workload[:, one.first_column:one.end_column].sum() for one in (first, second)]
    assert np.ptp(work) < made.workload.sum(axis=0).reshape(-1, 4).sum(axis=1).max()
    assert (first.first_column, first.end_column, second.end_column) == (0, second.first_column, 64)
    # It cannot be cut into more pieces than it has tiles.
    assert request(hemispheres(1), CONFIG.replace({"noc.columns": 8, "noc.rows": 8}), clusters=64).clusters == 32
    assert request(hemispheres(1, type(RAYS)(16, 8)), CONFIG, clusters=16).clusters == 8


def test_shadow_frusta_are_cut_by_their_rays_and_positions(monkeypatch):
    """All rays are in the left half of the grid, and a half of the positions."""
    for name in "machine_schedule", "low_density":
        monkeypatch.setattr(f"golden.engine.jobs.phase_request.{name}", None)
    geometry, record, _ = drawn_frustum(1, bits=4)
    right = np.tile(np.arange(16) >= 8, 16)
    one = replace(record, end=np.where(right, CONFIG.numbers.inverse.high, record.end))
    config = CONFIG.replace({"icu.shadow_bits": 8, "ctu.subshell_bits": 4})
    table = Shelling(geometry, config, cell=0.25).table
    made = phase_request([one, one], geometry, table, config, ratio=16, clusters=2)
    assert made.plan is None
    assert made.workload.sum() == pytest.approx(2)
    assert made.workload[:, 8:].sum() == pytest.approx(0.5)
    assert np.unique(made.workload.ravel()[one.listed]).tolist() == pytest.approx([1 / 256 + 1 / len(one.listed)])


def test_the_work_is_that_of_the_reference():
    config = CONFIG.replace({"icu.rays": 1024})
    first, other = hemispheres(4)[::3]
    (of_first, of_other, referred) = (request([one], config, reference=reference).workload for one, reference in (
        (first, None), (other, None), (first, other)))
    assert np.array_equal(referred, of_other)
    assert not np.array_equal(referred, of_first)


@pytest.mark.parametrize(("size", "lists"), [
    *((size, False) for size in [(64, 3), (3, 64), (40, 1), (2, 2), (1, 40), (1, 1)]),
    # Resident sets need a column for each of the two clusters.
    *((size, True) for size in [(64, 3), (3, 64), (40, 1), (2, 2)])])
def test_a_picture_of_any_size_is_scheduled(size, lists):
    config = CONFIG.replace({"ctu.subshell_bits": 10, "icu.rays": 1024}) if lists else CONFIG
    screen = screen_record(Screen(camera=open_scene("lobby").camera, width=size[0], height=size[1]),
                           scene().geometry.coordinates)
    made = request([screen], config, clusters=2)
    assert sum(one.section.rays for one in plan_job([made], config).sections if one) == len(screen)


def test_subshell_lists_and_resident_sets_where_the_machine_has_them():
    few = {"memsys.own_patches": 64}
    assert request(hemispheres(3), CONFIG.replace(few)).plan is None
    listed = CONFIG.replace({"ctu.subshell_bits": 10, "icu.rays": 1024, **few})
    made = request(hemispheres(3), listed, reference=hemispheres(4)[3])
    assert [len(one) for one in made.plan.sets.patches] == [64, 64]
    assert {one.cluster for one in plan_job([made], listed).sections if one} == {0, 1}
    # Their sections are pinned, and have to fit.
    with pytest.raises(InputError, match="the capacity is 256"):
        request(hemispheres(1), listed.replace({"icu.rays": 256}))
