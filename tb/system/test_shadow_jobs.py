"""Shadow frusta on the exported engine: every byte of main memory is golden's."""

import random
from dataclasses import fields, replace
from itertools import pairwise

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.frustum.bundle import Bundle
from golden.engine.frustum.record import FrustumRecord
from golden.engine.jobs.descriptor import list_words, near_bytes
from golden.engine.jobs.job import plan_job
from golden.engine.jobs.result_formats import bit_words, unpack_bits
from golden.engine.jobs.run_job import run_job
from hw.registers.error_code import ErrorCode
from radiosity.flow.simulator.simulated_port import complete
from tb.lib.seed import SEED
from tb.system.job_machine import BASE, CONFIGS, SHADOWS, JobMachine
from tb.system.scenes import phase, shadow_phases

CONFIG = CONFIGS[2].replace(SHADOWS)
CELL = 0.25
# Cycles from the begin of a section to the first ray of its list, and from the last one until it has settled.
LISTED = 40


def shadows(*, count, seed):
    """Phases of shadow frusta."""
    return shadow_phases("cornell", CONFIG, cell=CELL, count=count, seed=seed)


@pytest.fixture(scope="module")
def job():
    """In grids of one section and of several, behind and before frusta that use all rays."""
    common = {"cell": CELL, "rays": (32, 16)}
    return plan_job([
        phase("cornell", CONFIG, **common), *shadows(count=80, seed=1),
        phase("cornell", CONFIG, pixels=(30, 19), **common), *shadows(count=300, seed=2),
        phase("cornell", CONFIG, points=(1,), **common)], CONFIG, base=BASE)


def test_brute_force_leaves_the_same_bytes(job):
    """Some rays are blocked and some are not; larger grids take several sections, each with its own list."""
    memory, listed, found = run_job(job).memory, 0, 0
    assert run_job(job, brute_force=True).memory == memory
    for number, one in enumerate(job.phases):
        for frustum, record in enumerate(one.request.records):
            if record.bundle == Bundle.SHADOW:
                numbers = job.numbers(number, frustum)
                assert (len(numbers) > 1) == (len(record) > CONFIG.icu.rays)
                assert job.descriptors["ray_count"][numbers].sum() == len(record.listed)
                blocked = job.blocked(number, frustum, lambda address, size: memory[address][:size])
                assert np.array_equal(blocked, NaiveFixed(one.request.geometry, CONFIG.for_rays(len(record))).blocked(
                    record))
                listed, found = listed + len(record.listed), found + blocked.sum()
    assert 0 < found < listed


def test_words_that_follow_a_descriptor_hold_its_cells_of_shell_1_and_its_rays(job):
    for words, one in zip(list_words(job.descriptors), job.sections, strict=True):
        request = job.phases[one.phase].request if one else None
        assert words == (-(-len(near_bytes(request.records[one.frustum], request.table, one.section)) // 8)
                         if one else 0)


def test_rays_beside_the_section_of_a_descriptor_are_not_blocked(job):
    """A list may have more rays than those of the section: their bits are 0."""
    number = max((number for number, one in enumerate(job.sections) if one),
                 key=lambda number: job.descriptors["ray_count"][number])
    one, changed = job.sections[number], job.descriptors.copy()
    half = (one.section.first_column + one.section.end_column) // 2
    changed["end_column"][number] = half
    record = job.phases[one.phase].request.records[one.frustum]
    rays = one.section.among(record.listed, record)
    whole, part = (unpack_bits(run_job(job, descriptors).memory[int(changed["hits"][number])], len(rays))
                   for descriptors in (job.descriptors, changed))
    assert np.array_equal(part, whole & (rays % record.columns < half))
    assert 0 < part.sum() < whole.sum()


def test_nothing_overlaps_the_bits_of_long_lists():
    """Those of 512 rays fill what addresses are multiples of."""
    config = CONFIG.replace({"icu.rays": 4096, "icu.shadow_bits": 12})
    made = plan_job(shadows(count=6000, seed=2), config, base=BASE)
    words = [bit_words(int(count)) for count in made.descriptors["ray_count"]]
    assert max(words) > 8
    extents = sorted([*((address, len(data)) for address, data in made.tables().items()),
                      *((int(one["hits"]), 8 * count) for one, count, section in zip(
                          made.descriptors, words, made.sections, strict=True) if section), (made.end, 0)])
    assert all(address + size <= following for (address, size), (following, _) in pairwise(extents))


def test_halves_without_rays_are_left_out():
    """The last section for each cluster is cut in two; parts of a list have rays in few rows."""
    config = CONFIG.replace({"memsys.own_patches": 1024, "memsys.own_cells": 1024, "memsys.own_entries": 4096})
    request = max(shadows(count=300, seed=2), key=lambda one: one.records[0].columns)
    parts = [part for record in request.records for part in record.parts(8)]
    made = plan_job([replace(request, records=parts, cycles=[1e6] * len(parts))], config, base=BASE)
    cut = [one for one in made.sections if one and one.section.rays < len(parts[0])]
    counts = made.descriptors["ray_count"][[number for number, one in enumerate(made.sections) if one]]
    assert made.phases[0].image.has_copies
    assert cut
    assert counts.all()
    assert counts.sum() == sum(len(part.listed) for part in parts)


def test_shadow_frusta_and_others_are_no_phase():
    """Also of the same grid: the sections of others have their hits in one place."""
    request = shadows(count=80, seed=1)[0]
    record = request.records[0]
    screen = FrustumRecord(**{field.name: getattr(record, field.name) for field in fields(FrustumRecord)})
    for records in (record, screen), (screen, record):
        with pytest.raises(InputError, match="same rays; frustum 1 has others"):
            plan_job([replace(request, records=records)], CONFIG, base=BASE)


@pytest.mark.sim
def test_shadow_frusta_between_other_kinds(job):
    with JobMachine(job) as machine:
        machine.right()


@pytest.mark.sim
def test_a_stop_leaves_nothing_of_a_list(job):
    """At each end of a list, while its rays come and until they have settled: what comes after is right."""
    draw, counts = random.Random(SEED), job.descriptors["ray_count"]
    with JobMachine(job) as machine:
        machine.begin()
        machine.submit()
        now = machine(machine.host.read("cycles"))
        listed = [one for one in machine.ended() if counts[one["tag"]]]
        for number in range(6):
            one = draw.choice(listed)
            # When memories are swept depends on the frusta before.
            machine.port.reset()
            machine.begin()
            machine.submit()
            at = int(one["begin"]) - now + int(number % 2 and counts[one["tag"]]) + draw.randrange(LISTED)
            complete(machine.port.wait(at))
            machine(machine.host.command("stop"))
            before = machine.ended()
            aborted = {int(one["tag"]): ErrorCode.ABORTED for one in before if one["error"]}
            assert aborted, "a section is in flight"
            machine.check(np.array([*before, *machine.resumed()]), aborted)


@pytest.mark.sim
def test_a_list_that_cannot_be_read_ends_its_section_alone(job):
    """Whichever word of those behind the cells of shell 1."""
    with JobMachine(job, latency=5) as machine:
        tag = int(job.descriptors["ray_count"].argmax())
        first, words = int(job.descriptors["near_cells"][tag]), int(list_words(job.descriptors)[tag])
        for word in words - int(job.descriptors["ray_count"][tag]), words - 1:
            machine.port.fault(first=first + 8 * word, size=8)
            (record,) = [one for one in machine.right({tag: ErrorCode.READ_REPLY}) if one["tag"] == tag]
            assert record["address"] == first
        machine.port.fault()
        machine.right()
