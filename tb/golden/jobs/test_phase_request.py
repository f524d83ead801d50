"""What the host requests: whole frusta, or even shares of them; schedules only where they are needed."""

import numpy as np
import pytest

from golden.jobs.job import plan_job
from golden.jobs.phase_request import clusters_per_frustum, phase_request
from golden.jobs.result_formats import HitFormat
from tb.golden.jobs.jobs import CONFIG, RAYS, hemispheres, scene


def request(records, config, **given):
    return phase_request(records, scene().geometry, scene().shelling.table, config, ratio=16, **given)


@pytest.mark.parametrize(("frusta", "clusters", "shared"), [
    (1, 1, 1), (9, 1, 1), (1, 4, 4), (2, 4, 2), (3, 4, 4), (4, 4, 1), (5, 4, 1), (6, 8, 4), (8, 16, 2), (12, 16, 4)])
def test_each_cluster_has_the_same_number_of_sections(frusta, clusters, shared):
    assert clusters_per_frustum(frusta, clusters) == shared
    assert frusta >= clusters or frusta * shared % clusters == 0


def test_frusta_that_fill_the_machine_are_not_scheduled(monkeypatch):
    monkeypatch.setattr("golden.jobs.phase_request.machine_schedule", None)
    made = request(hemispheres(2), CONFIG, weights=RAYS.polar_weights, hit_format=HitFormat.COMPACT, sums=True)
    assert (made.clusters, made.plan, made.workload) == (1, None, None)
    assert (made.hit_format, made.sums, made.weights.tolist()) == (HitFormat.COMPACT, True, RAYS.polar_weights.tolist())


def test_a_single_frustum_is_cut_by_expected_work():
    config = CONFIG.replace({"icu.rays": 1024})
    made = request(hemispheres(1), config)
    assert (made.clusters, made.plan) == (2, None)
    first, second = (one.section for one in plan_job([made], config).sections if one)
    work = [made.workload[:, one.first_column:one.end_column].sum() for one in (first, second)]
    assert np.ptp(work) < made.workload.sum(axis=0).reshape(-1, 4).sum(axis=1).max()
    assert (first.first_column, first.end_column, second.end_column) == (0, second.first_column, 64)
    # It cannot be cut into more pieces than it has tiles.
    assert request(hemispheres(1), CONFIG.replace({"noc.columns": 8, "noc.rows": 8}), clusters=64).clusters == 32
    assert request(hemispheres(1, type(RAYS)(16, 8)), CONFIG, clusters=16).clusters == 8


def test_resident_sets_where_patches_do_not_fit_and_lists_where_there_are_any():
    few = CONFIG.replace({"memsys.own_patches": 64})
    made = request(hemispheres(3), few, reference=hemispheres(4)[3])
    assert (made.clusters, made.workload) == (1, None)
    assert [len(one) for one in made.plan.sets.patches] == [64, 64]
    listed = CONFIG.replace({"ctu.subshell_bits": 10, "icu.rays": 1024})
    job = plan_job([request(hemispheres(1), listed)], listed)
    assert {one.cluster for one in job.sections if one} == {0, 1}
