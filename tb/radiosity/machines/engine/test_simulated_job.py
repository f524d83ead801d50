"""Simulated jobs have the cycles of the hardware, and a store keeps their casts."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.engine import LATENCY
from benchmarks.machine_jobs import RecordedJob, job_config, recorded_jobs, simulate
from golden.base.errors import InputError
from golden.engine.ctu.sector import Sector
from golden.engine.jobs.job import plan_job
from radiosity.machines.engine.cluster_latencies import cluster_timing
from radiosity.machines.engine.job_latencies import job_timing, load_timing
from radiosity.machines.engine.job_runs import JobSpec, prepare_job
from radiosity.machines.engine.simulated_job import phase_casts, simulate_job

pytestmark = pytest.mark.usefixtures("interpreted")

SMALL = RecordedJob(spec=JobSpec(scene="cornell", rays=(16, 16), frusta=6, cell=1.0), clusters=2, cycles=0, load=0,
                    cast=0)


def errors(jobs):
    return {name: np.array([abs(of(job) / of(recorded) - 1) for recorded, job in jobs]) for name, of in {
        "cycles": lambda one: one.times.cycles if hasattr(one, "times") else one.cycles,
        "load": lambda one: one.times.load if hasattr(one, "times") else one.load}.items()}


def prepared(recorded, changes=None):
    """A job, its casts' arguments and the rest of a simulation's."""
    config = job_config(recorded).replace(changes or {})
    request = prepare_job(recorded.spec, config).request
    return plan_job([request], config), (request, config, cluster_timing(config)), {
        "job_timing": job_timing(config, latency=LATENCY), "load_timing": load_timing(config, latency=LATENCY)}


def test_cycles_are_those_of_the_hardware():
    alone = tuple(one for one in recorded_jobs() if one.spec.frusta == 1 and one.spec.scene == "tetra")
    found = errors([*simulate(alone)])
    assert found["load"].max() < 0.005
    assert found["cycles"].max() < 0.025


@pytest.mark.nightly
def test_cycles_of_short_jobs_are_those_of_the_hardware():
    # Those of whole scenes are in a table of `docs/machines.md`, which takes half an hour.
    short = tuple(one for one in recorded_jobs() if one.spec.frusta <= 64)
    found = errors([*simulate(short)])
    assert len(found["cycles"]) == 9
    assert found["cycles"].max() < 0.05
    assert found["load"].max() < 0.06


@pytest.mark.nightly
def test_another_rule_has_other_cycles():
    tetra, = (one for one in recorded_jobs() if one.spec.frusta == 1 and one.spec.scene == "tetra")
    job, casts, timings = prepared(tetra)
    store = phase_casts(*casts)
    # Words that take two cycles each.
    timings["load_timing"] = replace(timings["load_timing"], patch_words=12)
    assert simulate_job(job, store, **timings).times.cycles > 1.05 * tetra.cycles


def test_a_store_keeps_casts_in_files(tmp_path, monkeypatch):
    job, casts, timings = prepared(SMALL)
    first = simulate_job(job, phase_casts(*casts, folder=tmp_path), **timings)
    assert len([*tmp_path.iterdir()]) == SMALL.spec.frusta
    monkeypatch.setattr("radiosity.machines.engine.cast_store.cast_section", None)
    again = simulate_job(job, phase_casts(*casts, folder=tmp_path), **timings)
    assert np.array_equal(again.times.done, first.times.done)
    assert (again.tests, again.cast_cycles) == (first.tests, first.cast_cycles)


def test_casts_in_other_cells_are_other_files(tmp_path):
    for cell in (1.0, 0.5):
        _, (request, config, timing), _ = prepared(replace(SMALL, spec=replace(SMALL.spec, cell=cell)))
        record = request.records[0]
        phase_casts(request, config, timing, folder=tmp_path).cast(record, Sector.whole(record))
    assert len([*tmp_path.iterdir()]) == 2


def test_sections_together_have_the_tests_of_all_rays():
    job, casts, timings = prepared(replace(SMALL, spec=replace(SMALL.spec, group=2)))
    done = simulate_job(job, phase_casts(*casts), **timings)
    assert len(done.casts) == 2 * SMALL.spec.frusta
    assert done.times.cluster.max() == 1
    assert done.tests > 0.9 * SMALL.spec.frusta * 256


def test_clusters_without_all_patches_are_refused():
    job, casts, timings = prepared(SMALL, {"memsys.own_patches": 16})
    with pytest.raises(InputError, match="patches every cluster holds"):
        simulate_job(job, phase_casts(*casts), **timings)
