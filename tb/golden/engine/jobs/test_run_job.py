"""Results of a job: those of each frustum alone, in their formats, and nothing else in memory."""

from dataclasses import replace

import numpy as np
import pytest

from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.jobs.descriptor import DESCRIPTOR
from golden.engine.jobs.job import plan_job
from golden.engine.jobs.load_regions import LOADED_REGIONS, region_bits
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.jobs.run_job import run_job
from tb.golden.engine.jobs.jobs import CONFIG, hemispheres, job, memory_with, requests, scene
from tb.system.job_differences import job_differences


@pytest.fixture(scope="module")
def results():
    return run_job(job())


@pytest.fixture(scope="module")
def memory(results):
    return memory_with(job(), results.memory)


@pytest.fixture(scope="module")
def hits():
    """The hits of each frustum alone, by brute force."""
    naive = NaiveFixed(scene().geometry, CONFIG.replace({"icu.rays": 1024}))
    return [[naive.cast(record) for record in phase.request.records] for phase in job().phases]


def reader(memory):
    return lambda address, size: bytes(memory[address:address + size])


def words(results):
    return dict(zip(results.completions["tag"].tolist(), results.completions["sums"].tolist(), strict=True))


def test_hits_in_memory_are_those_of_each_frustum_alone(memory, hits):
    for frustum, expected in enumerate(hits[0]):
        assert not len(job().hits(0, frustum, reader(memory)).differences(expected))
    assert np.array_equal(job().hits(2, 0, reader(memory)), hits[2][0].patch)


def test_sums_in_memory_are_those_of_each_patch(memory, results, hits):
    for phase in 0, 1:
        request = job().phases[phase].request
        for frustum, expected in enumerate(hits[phase]):
            weights = np.repeat(request.weights, request.records[frustum].columns)
            assert np.array_equal(job().sums(phase, frustum, reader(memory), words(results)),
                                  [weights[expected.patch == patch].sum() for patch in range(len(scene().geometry))])


def test_completions_have_tags_and_words_and_no_errors(results):
    assert set(results.errors) == {"NONE"}
    assert results.completions["tag"].tolist() == list(range(len(job().descriptors)))
    for one, sums in zip(job().sections, results.completions["sums"].tolist(), strict=True):
        assert (sums > 0) == (one is not None and job().phases[one.phase].request.sums)


def test_results_stay_within_their_buffers(results):
    buffers = sorted([(address, address + len(record) * phase.request.hit_format.bytes) for phase in job().phases
                      for address, record in zip(phase.hits, phase.request.records, strict=True)]
                     + [(int(address), int(address) + 8 * len(scene().geometry))
                        for address in job().descriptors["sums_address"] if address])
    for address, data in results.memory.items():
        assert any(first <= address and address + len(data) <= end for first, end in buffers)


def test_shelling_and_brute_force_leave_the_same(results):
    again = run_job(job(), brute_force=True)
    assert again.memory == results.memory
    assert again.errors == results.errors
    assert again.completions.tobytes() == results.completions.tobytes()


def changed(number, **fields):
    descriptors = job().descriptors.copy()
    for name, value in fields.items():
        descriptors[name][number] = value
    return descriptors


def test_a_malformed_descriptor_leaves_the_others_as_they_are(results):
    refused = run_job(job(), changed(3, context=1))
    assert refused.errors == tuple("DESCRIPTOR" if number == 3 else "NONE" for number in range(len(results.errors)))
    assert refused.completions["address"][3] == DESCRIPTOR.dtype.fields["context"][1]
    assert refused.completions["sums"][3] == 0
    missing = results.memory.keys() - refused.memory.keys()
    assert missing
    assert all(refused.memory[address] == data for address, data in results.memory.items() if address not in missing)
    assert int(job().descriptors["sums_address"][3]) in missing


def test_a_frustum_before_any_load_completes_as_such(results):
    early = run_job(job(), changed(0, regions=LOADED_REGIONS & ~8))
    assert early.errors[1:11] == ("NOT_LOADED",) * 10
    assert not early.completions["sums"][1:11].any()


def test_one_load_must_read_all_regions_before_a_cast(results):
    others = int(job().descriptors["regions"][11])
    early = run_job(job(), changed(0, regions=LOADED_REGIONS & ~others))
    loads = [one is None for one in job().sections]
    assert early.errors == tuple("NONE" if is_load else "NOT_LOADED" for is_load in loads)
    assert results.errors == ("NONE",) * len(loads)


def test_weights_are_loaded_with_the_rows(results):
    regions = int(job().descriptors["regions"][11])
    assert regions & region_bits("rows", "columns") == region_bits("rows", "columns")
    assert run_job(job(), changed(11, regions=regions & ~region_bits("columns"))).memory == results.memory


def test_a_frustum_beyond_the_loaded_shells_completes_as_such(results):
    loaded = job().phases[0].image.last_shell
    for last, error, address in ((loaded, "NONE", 0), (loaded + 1, "NOT_LOADED", 52)):
        found = run_job(job(), changed(3, last_shell=last))
        assert found.errors == tuple(error if number == 3 else "NONE" for number in range(len(results.errors)))
        assert found.completions["address"][3] == address


def test_a_load_of_no_image_unloads(results):
    address = int(job().descriptors["hits"][11]) + 64
    wrong = run_job(job(), changed(11, hits=address))
    assert wrong.errors[11:] == ("IMAGE", *["NOT_LOADED"] * 3, "NONE", *["NOT_LOADED"] * 2)
    assert wrong.completions["address"][11] == address


def test_a_sum_beyond_its_word_ends_its_section():
    request = replace(requests()[0], records=hemispheres(1), cycles=None,
                      weights=np.full(16, (1 << 42) - 1, dtype=np.int64))
    for sums, error in ((True, "OVERFLOW"), (False, "NONE")):
        made = plan_job([replace(request, sums=sums)], CONFIG)
        over = run_job(made)
        assert over.errors == ("NONE", error, error)
        assert bool(over.memory) == (not sums)
        patches = NaiveFixed(scene().geometry, CONFIG.replace({"icu.rays": 1024})).cast(request.records[0]).patch
        if sums:
            assert set(over.completions["address"][1:].tolist()) <= set(patches.tolist())


def test_a_section_may_request_other_results_than_the_job(results, hits):
    number, = (number for number in job().numbers(0, 0)
               if job().sections[number].section.first_column == 0 and job().sections[number].section.first_row == 0)
    one = run_job(job(), changed(number, hit_format=HitFormat.FULL, sums=0, hits=job().end, end_column=1, end_row=1))
    (address,) = one.memory.keys() - results.memory.keys()
    assert address == job().end
    assert np.frombuffer(one.memory[address], "<i4")[:2].tolist() == [hits[0][0].inverse[0], hits[0][0].patch[0]]
    assert one.completions["sums"][number] == 0


NAMES = {0: "NONE", 7: "DESCRIPTOR"}


@pytest.mark.parametrize("malformed", [False, True])
def test_completions_in_any_order_are_no_difference(malformed):
    results = run_job(job(), changed(4, kind=2) if malformed else None)
    records = np.random.default_rng(0).permutation(results.completions)
    records["error"] = [7 if results.errors[tag] == "DESCRIPTOR" else 0 for tag in records["tag"]]
    memory = memory_with(job(), results.memory)
    assert job_differences(results, records, reader(memory), NAMES) == []
    assert 7 in records["error"] or not malformed


def test_every_difference_is_a_line(results, memory):
    def lines(change=lambda records: records, memory=memory):
        return job_differences(results, change(results.completions.copy()), reader(memory), NAMES)

    def with_field(name, value):
        def change(records):
            records[name][2] = value
            return records
        return change

    last = len(results.completions) - 1
    assert lines(lambda records: records[:-1]) == [
        f"{last} completions instead of {last + 1}", f"tag {last} does not complete"]
    assert lines(with_field("tag", 1)) == ["tag 1 is unknown, or completes again", "tag 2 does not complete"]
    assert lines(with_field("tag", 99)) == ["tag 99 is unknown, or completes again", "tag 2 does not complete"]
    assert lines(with_field("error", 7)) == ["tag 2: DESCRIPTOR instead of NONE"]
    words = results.completions["sums"][2]
    assert lines(with_field("sums", words + 1)) == [f"tag 2: {words + 1} words of sums instead of {words}"]
    for address, data in results.memory.items():
        other = bytearray(memory)
        other[address + len(data) - 1] ^= 1
        assert lines(memory=other) == [f"{len(data)} bytes at {address:#x} are other ones"]


def test_an_error_at_another_byte_is_a_difference():
    results = run_job(job(), changed(4, kind=2))
    records = results.completions.copy()
    records["error"][4], records["address"][4] = 7, 3
    assert job_differences(results, records, reader(memory_with(job(), results.memory)), NAMES) == [
        "tag 4: DESCRIPTOR at 0x3 instead of 0x2"]
