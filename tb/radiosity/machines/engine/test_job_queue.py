"""The cycles of a job are those of its restatement in SimPy, and follow from its rules."""

from dataclasses import asdict

import numpy as np
import pytest

from radiosity.machines.engine.job_queue import JobSections, run_queue
from radiosity.machines.engine.job_timing import JobTiming
from tb.radiosity.machines.engine.simpy_queue import simpy_queue

pytestmark = pytest.mark.usefixtures("interpreted")

TIMING = JobTiming(first=2, dispatch=28, slot=2, restart=1, read_out=9, sums=16, answer=23, report=10, beats=16,
                   buffers=2)


def sections(count, *, cycles=1000, rays=256, hits=0, sums=0):
    return JobSections(**{name: np.full(count, value) for name, value in {
        "near": 4, "free": cycles // 2, "cycles": cycles, "rays": rays, "hits": hits, "sums": sums}.items()})


def drawn(seed, *, count, hits):
    rng = np.random.default_rng(seed)
    cycles, rays = rng.integers(50, 4000, count), rng.integers(16, 2000, count)
    return JobSections(near=rng.integers(0, 9, count), free=cycles * rng.random(count) // 1, cycles=cycles, rays=rays,
                       hits=rays * hits // 8, sums=rng.integers(0, 900, count))


@pytest.mark.parametrize(("seed", "clusters", "hits"), [
    (seed, clusters, hits) for seed, (clusters, hits) in enumerate(
        (clusters, hits) for clusters in (1, 5, 16) for hits in (0, 16))])
def test_events_are_those_of_processes_in_simpy(seed, clusters, hits):
    given = drawn(seed, count=60, hits=hits)
    times, expected = (run(given, TIMING, clusters=clusters, load=100) for run in (run_queue, simpy_queue))
    for name in ("cluster", "begins", "ends", "done"):
        assert np.array_equal(getattr(times, name), getattr(expected, name)), name


def test_a_cluster_begins_the_next_section_after_the_one_before():
    times = run_queue(sections(3), TIMING, clusters=1, load=50)
    assert times.begins[0] == 50 + TIMING.first + TIMING.dispatch + 4 + TIMING.slot
    assert np.array_equal(np.diff(times.begins), [1000 + TIMING.restart] * 2)
    assert times.cycles == times.ends[-1] + TIMING.read_out + 256 + TIMING.sums + TIMING.answer


def test_results_that_take_longer_than_casts_delay_them():
    times = run_queue(sections(4, cycles=300, rays=1024), TIMING, clusters=1, load=0)
    each = TIMING.read_out + 1024 + TIMING.sums + TIMING.answer + TIMING.report
    assert np.array_equal(np.diff(times.begins)[1:], [each] * 2)


def test_hits_of_all_clusters_share_the_port():
    given = sections(64, cycles=100, rays=256, hits=512)
    times = [run_queue(given, TIMING, clusters=clusters, load=0).cycles for clusters in (4, 16)]
    assert min(times) > 64 * 512
    assert times[1] > 0.98 * times[0]


def test_a_job_without_sections_ends_with_its_load():
    assert run_queue(sections(0), TIMING, clusters=2, load=77).cycles == 77


@pytest.mark.parametrize(("wrong", "error", "message"), [
    ({"read_out": -1}, ValueError, "Read-out must be at least 0, not -1"),
    ({"buffers": 0}, ValueError, "Buffers must be at least 1, not 0"),
    ({"slot": 1.5}, TypeError, "Slot must be an int, not 1.5")])
def test_numbers_out_of_range_are_refused(wrong, error, message):
    with pytest.raises(error, match=message):
        JobTiming(**asdict(TIMING) | wrong)
