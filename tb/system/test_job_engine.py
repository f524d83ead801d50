"""Jobs on the exported `Engine`: all of main memory, and a completion record for each descriptor."""

import functools

import numpy as np
import pytest

from golden.cast.shelling import Shelling
from golden.frustum import Hemisphere, Screen, hemisphere_record, screen_record
from golden.jobs.descriptor import Kind
from golden.jobs.job import Job, PhaseRequest, plan_job
from golden.jobs.result_formats import HitFormat
from golden.scene.open import open_scene
from golden.scene.patch_geometry import PatchGeometry
from golden.scene.view import default_camera
from golden.schedule.ceiling_points import ceiling_points
from hw.registers.error_code import ErrorCode
from hw.simulator.simulated_port import complete
from tb.system.job_machine import CLUSTERS, CONFIGS, JobMachine

RAYS = Hemisphere(32, 16)
# Cycles from the end of a cast to the beginning of the next one, of sections that wait.
GAP = 40


@functools.cache
def scene(clusters):
    """`cornell`: geometry, cells, and points of the ceiling."""
    config, opened = CONFIGS[clusters], open_scene("cornell")
    points, down = ceiling_points(opened)
    geometry = PatchGeometry.of(opened, config.numbers, [*points, (opened.camera or default_camera(opened)).eye])
    return geometry, Shelling(geometry, config, cell=0.25).table, points, down


def hemispheres(clusters, *points, group=1, **given) -> PhaseRequest:
    geometry, table, ceiling, down = scene(clusters)
    given = {"hit_format": HitFormat.FULL, "sums": True, "weights": RAYS.polar_weights} | given
    return PhaseRequest(geometry=geometry, table=table, records=[
        hemisphere_record(RAYS, geometry.coordinates, ceiling[point], down) for point in points], clusters=group,
        **given)


def screens(clusters, **given) -> PhaseRequest:
    geometry, table, *_ = scene(clusters)
    opened = open_scene("cornell")
    screen = Screen(camera=opened.camera or default_camera(opened), width=30, height=19)
    return PhaseRequest(geometry=geometry, table=table, records=[screen_record(screen, geometry.coordinates)], **given)


def planned(clusters, *requests, **given) -> Job:
    return plan_job(requests, CONFIGS[clusters], **given)


def casts(machine, records):
    """Completion records of sections, in the order in which they began."""
    kinds = machine.job.descriptors["kind"]
    found = records[[kinds[tag] == Kind.FRUSTUM for tag in records["tag"]]]
    return found[np.argsort(found["begin"])]


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_sections_follow_each_other_without_a_gap(clusters):
    job = planned(clusters, hemispheres(clusters, 5, 6, 9, 10, 0, 3))
    with JobMachine(job) as machine:
        machine.begin()
        records = machine.run()
        machine.check(records)
        found = casts(machine, records)
        assert {*found["cluster"]} == {*range(clusters)}, "each cluster takes its share"
        assert sorted(records["tag"]) == [*range(len(job.descriptors))], "each descriptor completes once"
        for cluster in range(clusters):
            own = found[found["cluster"] == cluster]
            gaps = own["begin"][1:].astype(int) - own["begin"][:-1] - own["cycles"][:-1]
            assert (gaps <= GAP).all(), f"gaps of cluster {cluster}: {gaps.tolist()}"
            assert (own["end"].astype(int) - own["begin"] >= own["cycles"]).all()
        assert (found["tested"] > 0).all()
        assert (found["found"] == found["own"] + found["remote"] + found["hits"] + found["misses"]).all()


@pytest.mark.parametrize("clusters", CLUSTERS)
@pytest.mark.parametrize("hit_format", [HitFormat.NONE, HitFormat.COMPACT, HitFormat.IDS])
def test_formats_of_hits(clusters, hit_format):
    job = planned(clusters, hemispheres(clusters, 5, 6, hit_format=hit_format, sums=hit_format != HitFormat.IDS))
    with JobMachine(job) as machine:
        machine.begin()
        machine.check(machine.run())


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_phases_change_in_the_queue(clusters):
    """Hemispheres, a screen, hemispheres again: loads lie between them, in a ring that is shorter than the job."""
    job = planned(clusters, hemispheres(clusters, 5, 6, 9), screens(clusters, hit_format=HitFormat.FULL),
                  hemispheres(clusters, 3, 4, sums=False), ring_bits=2, base=1 << 12)
    assert list(job.descriptors["kind"]).count(Kind.LOAD) == 3
    with JobMachine(job) as machine:
        machine.begin()
        machine.check(machine.run())


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_a_frustum_of_several_sections(clusters):
    job = planned(clusters, hemispheres(clusters, 5, 6, group=4))
    assert len(job.descriptors) == 1 + 2 * 4
    with JobMachine(job) as machine:
        machine.begin()
        records = machine.run()
        machine.check(records)

        def read(address, size):
            return complete(machine.port.read_memory(address, size))

        words = {int(one["tag"]): int(one["sums"]) for one in records}
        weights = RAYS.polar_weights
        for frustum in range(2):
            hits = job.hits(0, frustum, read)
            expected = np.bincount(hits.patch[hits.inverse > 0], minlength=len(scene(clusters)[0]), weights=np.repeat(
                weights, RAYS.azimuths)[hits.inverse > 0])
            assert job.sums(0, frustum, read, words).tolist() == expected.astype(np.int64).tolist()


@pytest.mark.parametrize("clusters", CLUSTERS)
@pytest.mark.parametrize(("field", "value", "code"), [
    ("version", 2, ErrorCode.DESCRIPTOR), ("kind", 2, ErrorCode.DESCRIPTOR), ("hits", 8, ErrorCode.DESCRIPTOR),
    ("end_column", 33, ErrorCode.SECTION), ("cluster", 7, ErrorCode.DESCRIPTOR)])
def test_a_malformed_descriptor_harms_nobody(clusters, field, value, code):
    job = planned(clusters, hemispheres(clusters, 5, 6, 9))
    with JobMachine(job) as machine:
        machine.begin()
        descriptors = machine.job.descriptors.copy()
        descriptors[field][2] = value
        records = machine.run(descriptors)
        (refused,) = records[records["tag"] == 2]
        assert ErrorCode(int(refused["error"])) is code
        machine.check(records, refused={2})


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_a_frustum_before_a_load_is_refused(clusters):
    job = planned(clusters, hemispheres(clusters, 5, 6))
    with JobMachine(job) as machine:
        machine.begin()
        descriptors = machine.job.descriptors[[1, 0, 2]]
        records = machine.run(descriptors)
        assert [ErrorCode(int(one["error"])) for one in records if one["tag"] == 1] == [ErrorCode.NOT_LOADED]
        machine.check(records, refused={1})


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_a_write_that_memory_refuses_is_its_sections_error(clusters):
    job = planned(clusters, hemispheres(clusters, 5, 6, 9, 10))
    with JobMachine(job) as machine:
        machine.begin()
        tag = 3
        machine.port.fault(first=int(machine.job.descriptors["hits"][tag]), size=64)
        records = machine.run()
        (failed,) = records[records["tag"] == tag]
        assert ErrorCode(int(failed["error"])) is ErrorCode.WRITE_REPLY
        assert failed["address"] == machine.job.descriptors["hits"][tag]
        others = records[records["tag"] != tag]
        assert (others["error"] == 0).all()


@pytest.mark.parametrize("clusters", CLUSTERS)
@pytest.mark.parametrize("cycles", [300, 4000, 6000, 9000])
def test_a_stop_aborts_what_is_in_flight_and_the_queue_resumes(clusters, cycles):
    job = planned(clusters, hemispheres(clusters, 5, 6, 9, 10, 0, 3))
    with JobMachine(job) as machine:
        machine.begin()
        host, count = machine.host, len(job.descriptors)
        complete(host.submit(machine.job, machine.job.descriptors))
        complete(machine.port.wait(cycles))
        complete(host.command("stop"))
        complete(machine.until(lambda status: status["halted"] and not status["busy"]))
        records = [*complete(host.collect(machine.job))]
        aborted = frozenset(int(one["tag"]) for one in records if one["error"] == ErrorCode.ABORTED.value)
        assert 1 <= len(aborted) <= 3 * clusters + 1, "what was in flight is aborted"
        complete(host.resume(machine.image()))
        complete(machine.until(lambda status: not status["busy"]))
        records += [*complete(host.collect(machine.job))]
        assert sorted(int(one["tag"]) for one in records) == [*range(count)], "each descriptor completes once"
        machine.check(records, aborted=aborted)
