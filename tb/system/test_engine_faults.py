"""Faults in a job: they end what they concern with their code, the other frusta are right, and so is the next job."""

import random
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from golden.engine.cast.shelling import Shelling
from golden.engine.ctu.sector import Sector
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.memory_map import REGIONS
from golden.engine.memsys.bus.reference_strings import ReferenceStrings
from hw.registers.engine_registers import register
from hw.registers.error_code import ErrorCode
from radiosity.flow.host import EngineError
from radiosity.flow.simulator.simulated_port import complete
from tb.lib.seed import NIGHTS, SEED
from tb.system.job_machine import CLUSTERS, SMALL, TWO_CLUSTERS, JobMachine, cornell, planned

POINTS = (5, 6, 9, 10, 0, 3)


def codes(records):
    """Error codes by tag, of what has ended with one."""
    return {int(one["tag"]): ErrorCode(int(one["error"])) for one in records if one["error"]}


def of_tag(records, tag):
    """The completion record of a descriptor."""
    (one,) = [one for one in records if one["tag"] == tag]
    return one


def sound(machine):
    """With a memory that is sound again the next job is right."""
    machine.port.fault()
    complete(machine.port.wait(2000))
    machine.right()


# A field, and what it must not be: for each rule of `golden.engine.jobs.descriptor.RULES` one at least.
MALFORMED = (
    ("version", 2), ("kind", 2), ("hit_format", 4), ("sums", 2), ("context", 1), ("cluster", 2), ("cluster", 0xFFFE),
    ("hits", 8), ("hits", 1 << 44), ("sums_address", 16), ("sums_address", 1 << 63), ("end_column", 0), ("end_row", 0),
    ("first_column", 32), ("end_column", 33), ("end_row", 17), ("near_cells", 4), ("near_cells", 1 << 44),
    ("near_count", 33), ("last_shell", 0), ("last_shell", 16), ("reserved", 1), ("ray_count", 1),
    ("bundle", 2), ("columns", 65), ("rows", 65))


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_malformed_descriptors_harm_nobody(clusters):
    """Each of them lies between two good ones; the codes and the fields named are golden's."""
    points = [POINTS[number % len(POINTS)] for number in range(2 * len(MALFORMED) + 1)]
    job = planned(clusters, cornell(clusters, points=points, rays=(32, 16), hit_format=HitFormat.IDS))
    descriptors = job.descriptors.copy()
    for number, (field, value) in enumerate(MALFORMED):
        descriptors[field][2 * number + 2] = value
    with JobMachine(job, descriptors) as machine:
        refused = [code for code in machine.memory.expected.errors if code != "NONE"]
        assert len(refused) == len(MALFORMED)
        machine.right()


@pytest.mark.sim
@pytest.mark.parametrize("clusters", CLUSTERS)
def test_a_section_larger_than_the_ray_memory(clusters):
    job = planned(clusters, cornell(clusters, points=(5, 6), rays=(64, 32)))
    descriptors = job.descriptors.copy()
    descriptors["first_column"][2] = max(0, descriptors["first_column"][2] - 1)
    descriptors["end_column"][2] = descriptors["first_column"][2] + 33
    assert SMALL["icu.rays"] == 32 * 32
    with JobMachine(job, descriptors) as machine:
        assert machine.memory.expected.errors[2] == "SECTION"
        machine.right()


def broken_images(image):
    """What loads of an image end with, or else the sections after them: bytes, and both codes."""
    offsets, data = image.offsets, image.to_bytes()

    def changed(at, value, size=4):
        broken = bytearray(data)
        broken[at:at + size] = value.to_bytes(size, "little")
        return bytes(broken)

    lists, entry = len(image["patch_lists"]), 16
    order = [region.name for region in REGIONS]
    where = {name: entry + 16 * number for number, name in enumerate(order)}
    yield changed(0, 1), "IMAGE", "NOT_LOADED"
    yield changed(4, 2), "IMAGE", "NOT_LOADED"
    for name in "cells", "columns", "grid_columns", "clusters":
        yield changed(where[name], offsets[name] + 8, 8), "REGION", "NOT_LOADED"
    yield changed(where["rows"] + 8, 1 << 32, 8), "REGION", "NOT_LOADED"
    yield changed(offsets["clusters"] + 8, 999), "POINTER", "NOT_LOADED"
    yield changed(offsets["cell_grid"] + 16, 1 << 20), "SIZE", "NOT_LOADED"

    def table(name, **fields):
        records, first = image[name].copy(), offsets[name]
        for field, value in fields.items():
            records[field] = value
        return data[:first] + records.tobytes() + data[first + records.nbytes:]

    yield table("cells", pointer=lists), "POINTER", "NOT_LOADED"
    yield table("patch_lists", patch=len(image["patches"])), "POINTER", "NOT_LOADED"
    # What a load accepts: the last cluster does not hold the patches.
    yield table("residence", cluster=len(image["clusters"]) - 1, address=SMALL["memsys.own_patches"] - 1), "NONE", (
        "PATH_RESIDENCE")


@pytest.mark.sim
@pytest.mark.parametrize("clusters", CLUSTERS)
def test_images_that_are_wrong(clusters):
    """In one job a load of each of them, a frustum, a load of what is right, a frustum."""
    images = list(broken_images(planned(clusters, cornell(clusters)).phases[0].image))
    job = planned(clusters, cornell(clusters, points=(5, 6) * len(images)))
    extra, errors, order, address = {}, {}, [], job.end
    for number, (data, *names) in enumerate(images):
        extra[address] = data
        errors |= {4 * number + k: ErrorCode[name] for k, name in enumerate(names)}
        order += [(0, address), (1 + 2 * number, None), (0, None), (2 + 2 * number, None)]
        address += -(-len(data) // 64) * 64
    descriptors = job.descriptors[[number for number, _ in order]]
    descriptors["tag"] = np.arange(len(order))
    for number, (_, image) in enumerate(order):
        descriptors["hits"][number] = image or descriptors["hits"][number]
    job = replace(job, descriptors=descriptors, sections=tuple(job.sections[number] for number, _ in order))
    with JobMachine(job, extra=extra) as machine:
        machine.right(errors)


@pytest.mark.sim
@TWO_CLUSTERS
def test_a_patch_that_the_cluster_named_for_it_has_not():
    """The sections that request it end with an error; those that the named cluster casts are right."""
    job = planned(2, cornell(2, points=(0,) * 3, sets="scheduled", clusters=2))
    (one,), sections = job.phases, [each for each in job.sections if each]
    shelling = Shelling.of_cells(one.request.geometry, one.request.table, job.config)
    halves = sorted({(each.section.first_column, each.section.end_column) for each in sections})
    (requests,) = ReferenceStrings.of(shelling, one.request.records[:1], tuple(
        Sector(*columns, 0, one.request.records[0].rows) for columns in halves)).patches
    left, right = ({*patches.tolist()} for patches in requests)
    patch = min(left - right)
    descriptors = job.descriptors.copy()
    wrong = [tag for tag, each in enumerate(job.sections) if each and not each.section.first_column]
    descriptors["cluster"][1:] = [tag in wrong for tag in range(1, len(descriptors))]
    with JobMachine(job, descriptors) as machine:
        machine.begin()
        record = np.array([(0, SMALL["memsys.own_patches"] - 1)], one.image["residence"].dtype)
        machine.write(one.address + one.image.offsets["residence"] + patch * record.itemsize, record.tobytes())
        records = machine.run()
        assert codes(records) == dict.fromkeys(wrong, ErrorCode.PATH_RESIDENCE)
        assert {int(each["address"]) for each in records if each["error"]} == {patch}
        machine.check(records, codes(records))
        machine.right()


@pytest.mark.sim
@pytest.mark.parametrize("clusters", CLUSTERS)
def test_tables_that_change_after_their_load(clusters):
    """Records of cells and lists in main memory that do not fit a cluster, and near cells."""
    job = planned(clusters, cornell(clusters, points=(5, 6)))
    image, address = job.phases[0].image, job.phases[0].address
    cells = image["cells"].copy()
    cells["pointer"] = len(image["patch_lists"])
    patches = np.full(len(image["patch_lists"]), len(image["patches"]), "<u4")
    near = np.full(int(job.descriptors["near_count"][1]), SMALL["memsys.scene_cells"] - 1, "<u4")
    with JobMachine(job) as machine:
        for where, data, codes_of in (
                (address + image.offsets["cells"], cells.tobytes(), ("PATH_BUS",) * 2),
                (address + image.offsets["patch_lists"], patches.tobytes(), ("PATH_PATCH",) * 2),
                (int(job.descriptors["near_cells"][1]), near.tobytes(), ("PATH_CELL", "NONE"))):
            machine.begin()
            machine(machine.host.submit(job, job.descriptors[:1]))
            machine.until("busy")
            machine.write(where, data)
            machine(machine.host.submit(job, job.descriptors[1:]))
            records = np.array(machine.ended())
            assert [codes(records).get(tag, ErrorCode.NONE).name for tag in (1, 2)] == list(codes_of)
            machine.check(records, codes(records))
        sound(machine)


@pytest.mark.sim
@pytest.mark.parametrize("clusters", CLUSTERS)
def test_memory_that_refuses(clusters):
    """What one descriptor reads or writes; then a region that a load reads."""
    job = planned(clusters, cornell(clusters, points=POINTS[:4]))
    tag, image = 3, job.phases[0].image
    with JobMachine(job, latency=5) as machine:
        for field, code in (("hits", "WRITE_REPLY"), ("sums_address", "WRITE_REPLY"), ("near_cells", "READ_REPLY")):
            first = int(job.descriptors[field][tag])
            machine.port.fault(first=first, size=8)
            records = machine.right({tag: ErrorCode[code]})
            assert of_tag(records, tag)["address"] == first
        for region in "cells", "patch_lists", "residence", "clusters", "columns", "grid_columns":
            first = job.phases[0].address + image.offsets[region]
            machine.port.fault(first=first, size=1)
            errors = dict.fromkeys(range(1, 5), ErrorCode.NOT_LOADED) | {0: ErrorCode.READ_REPLY}
            assert of_tag(machine.right(errors), 0)["address"] == first, region
        # Patches that are read during a cast.
        machine.port.fault(first=job.phases[0].address + image.offsets["patches"], size=image["patches"].nbytes)
        machine.begin()
        records = machine.run()
        assert {*codes(records).values()} <= {ErrorCode.PATH_BUS, ErrorCode.READ_REPLY}
        machine.check(records, codes(records))
        sound(machine)


@pytest.mark.sim
@pytest.mark.parametrize("clusters", CLUSTERS)
@pytest.mark.parametrize("ring", ["ring", "completions"])
def test_rings_that_memory_refuses(clusters, ring):
    """The queue halts, with the entry's address, and resumes when memory is sound again."""
    job = planned(clusters, cornell(clusters, points=POINTS[:4]))
    with JobMachine(job) as machine:
        machine.begin()
        address = job.entry(3) if ring == "ring" else job.completion(2)
        machine.port.fault(first=address, size=64)
        machine.submit()
        machine.until("halted", 1)
        code = ErrorCode.READ_REPLY if ring == "ring" else ErrorCode.WRITE_REPLY
        assert machine(machine.host.read("error")) == code.value
        assert machine(machine.host.read("error_address")) == address
        assert machine(machine.host.status())["unwritten"] == (ring == "completions")
        machine.port.fault()
        records = [*machine(machine.host.collect(job)), *machine.resumed()]
        machine.check(np.array(records), codes(records))
        assert {*codes(records).values()} <= {ErrorCode.ABORTED, ErrorCode.NONE}
        sound(machine)


@pytest.mark.sim
@pytest.mark.parametrize("clusters", CLUSTERS)
def test_a_run_whose_records_cannot_be_written_is_an_error(clusters):
    """Soon, and with the record's number; of an earlier error with that, and with the number."""
    job = planned(clusters, cornell(clusters, points=POINTS[:4]))
    with JobMachine(job) as machine:
        for watchdog, message in ((1 << 20, "^completion record 2 cannot be written: WRITE_REPLY: main memory "),
                                  (200, r"^completion record \d+ cannot be written: WATCHDOG: ")):
            machine.begin()
            first = machine(machine.host.read("completed"))
            machine.port.fault(first=job.completion(first + 2 if watchdog > 200 else first), size=64)
            machine(machine.host.write("watchdog", watchdog))
            with pytest.raises(EngineError, match=message):
                machine.run(timeout=1 << 16)
            machine(machine.host.write("watchdog", 1 << 20))
            machine.port.fault()
            machine.resumed()
        sound(machine)


@pytest.mark.sim
@pytest.mark.parametrize("clusters", CLUSTERS)
def test_accesses_outside_the_windows(clusters):
    """Of one section's results, of near cells, and of an image."""
    job = planned(clusters, cornell(clusters, points=POINTS[:4]))
    tag = 2
    with JobMachine(job, latency=5) as machine:
        for field, code in ("hits", "WRITE_REPLY"), ("sums_address", "WRITE_REPLY"), ("near_cells", "READ_REPLY"):
            machine.begin()
            descriptors = job.descriptors.copy()
            descriptors[field][tag] = job.base - (1 << 12)
            records = machine(machine.host.run(job, descriptors))
            assert codes(records) == {tag: ErrorCode[code]}
            assert of_tag(records, tag)["address"] == descriptors[field][tag]
            machine.check(records, codes(records))
        machine.begin()
        machine(machine.host.write("read_limit", job.phases[0].address + 4096))
        records = machine.run()
        assert codes(records)[0] is ErrorCode.READ_OUTSIDE
        # Neither can the near cells be read, which are behind the image.
        assert {*codes(records).values()} == {ErrorCode.READ_OUTSIDE, ErrorCode.READ_REPLY}
        machine.check(records, codes(records))
        sound(machine)


@pytest.mark.sim
@pytest.mark.parametrize("clusters", CLUSTERS)
def test_windows_rewritten_while_they_are_used(clusters):
    """The host rewrites them and the ring's registers, word by word, to any value: they are taken over in a halt."""
    job, draw = planned(clusters, cornell(clusters, points=POINTS[:4])), random.Random(SEED)
    names = "read_base", "read_limit", "write_base", "write_limit", "ring", "completions", "ring_bits"
    with JobMachine(job) as machine:
        machine.begin()
        machine.submit()
        while machine(machine.host.status())["busy"]:
            name = draw.choice(names)
            ones = register(name).ones(job.config.memory.address_bits)
            machine(machine.host.write(name, draw.getrandbits(64) & ones))
        machine.check(machine(machine.host.collect(job)))
        sound(machine)


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_sums_that_overflow(clusters):
    """The weights of one phase are too large."""
    job = planned(
        clusters, cornell(clusters, points=POINTS[:3], weights=np.full(16, 1 << 41), hit_format=HitFormat.NONE),
        cornell(clusters, points=(1, 2)))
    with JobMachine(job) as machine:
        assert machine.memory.expected.errors.count("OVERFLOW") == 3
        machine.right()


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_commands_that_are_refused(clusters):
    """A resume of a queue that is not halted, no bit, and a doorbell that is too far ahead."""
    job = planned(clusters, cornell(clusters, points=POINTS), ring_bits=3)
    with JobMachine(job) as machine:
        host = machine.host
        machine.begin()
        machine.submit()
        for command in {"resume": 1}, {}:
            machine(host.command(*command))if command else machine(host.write("command", 0))
            assert machine(host.status())["failed"]
            assert machine(host.read("error")) == ErrorCode.COMMAND.value
            machine(host.command("clear"))
            assert not machine(host.status())["failed"]
        machine.until("busy")
        machine.check(machine(host.collect(job)))
        taken = machine(host.read("taken"))
        machine(host.write("doorbell", taken + 9))
        machine.until("halted", 1)
        assert machine(host.read("error")) == ErrorCode.RING.value
        machine(host.write("doorbell", machine(host.read("taken"))))
        machine.ended()
        machine.resumed()
        sound(machine)


@pytest.mark.sim
@pytest.mark.parametrize("clusters", CLUSTERS)
@pytest.mark.parametrize("muted", ["reads", "writes"])
def test_memory_that_does_not_answer(clusters, muted):
    """From some time on: in a load, in casts."""
    job = planned(clusters, cornell(clusters, points=POINTS))
    with JobMachine(job) as machine:
        for cycles in 300, 2500:
            machine.begin()
            machine.submit()
            complete(machine.port.wait(cycles))
            machine.port.fault(**{f"mute_{muted}": True})
            complete(machine.port.wait(5000))
            machine.port.fault()
            records = machine.ended()
            if machine(machine.host.status())["halted"]:
                records += machine.resumed()
            found = codes(records)
            kinds = ("READ", "PATH_BUS", "PATH_TIMEOUT", "NOT_LOADED", "ABORTED") if muted == "reads" else (
                "WRITE", "ABORTED")
            assert found
            assert all(code.name.startswith(kinds) for code in found.values())
            machine.check(np.array(records), found)
            sound(machine)


@pytest.mark.parametrize("clusters", CLUSTERS)
@pytest.mark.parametrize("cycles", [4000, *(pytest.param(other, marks=pytest.mark.sim) for other in (300, 6000, 9000))])
def test_a_stop_aborts_what_is_in_flight_and_the_queue_resumes(clusters, cycles):
    job = planned(clusters, cornell(clusters, points=POINTS))
    with JobMachine(job) as machine:
        machine.begin()
        machine.submit()
        complete(machine.port.wait(cycles))
        machine(machine.host.command("stop"))
        records = machine.ended()
        aborted = codes(records)
        assert {*aborted.values()} == {ErrorCode.ABORTED}
        assert len(aborted) <= 3 * clusters + 1, "what was in flight is aborted"
        records += machine.resumed()
        machine.check(np.array(records), aborted)


@pytest.mark.sim
@pytest.mark.parametrize("clusters", CLUSTERS)
def test_the_watchdog_ends_what_takes_too_long_and_nothing_else(clusters):
    job = planned(clusters, cornell(clusters, points=POINTS))
    with JobMachine(job) as machine:
        host = machine.host
        records = machine.right()
        longest = int(records["cycles"].max())
        load = int(of_tag(records, 0)["end"]) - int(of_tag(records, 0)["begin"])
        machine(host.write("watchdog", 2 * (load + longest)))
        machine.right()
        for limit, tags in ((longest // 2, range(1, 7)), (100, range(1))):
            machine.begin()
            machine(host.write("watchdog", limit if limit > 100 else 1 << 20))
            if limit > 100:
                machine(host.write("watchdog", 0))
                machine(host.submit(job, job.descriptors[:1]))
                machine.until("busy")
                machine(host.write("watchdog", limit))
                machine(host.submit(job, job.descriptors[1:]))
            else:
                machine(host.write("watchdog", limit))
                machine.submit()
            records = machine.ended()
            assert machine(host.read("error")) == ErrorCode.WATCHDOG.value
            found = codes(records)
            (culprit,) = (tag for tag, code in found.items() if code is ErrorCode.WATCHDOG)
            assert culprit in tags
            assert {*found.values()} <= {ErrorCode.WATCHDOG, ErrorCode.ABORTED}
            machine(host.write("watchdog", 1 << 20))
            records += machine.resumed()
            machine.check(np.array(records), found)
        sound(machine)


@pytest.mark.sim
@pytest.mark.parametrize("clusters", CLUSTERS)
def test_resets_at_any_time(clusters):
    """Of machine and memory together."""
    job = planned(clusters, cornell(clusters, points=POINTS[:2]))
    with JobMachine(job, latency=8) as machine:
        for cycles in (1, 77, 700, 3000, 6000):
            machine.begin()
            machine.submit()
            complete(machine.port.wait(cycles))
            machine.port.reset()
            assert machine(machine.host.status()) == dict.fromkeys(machine(machine.host.status()), 0)
            machine.right()


@pytest.mark.parametrize("clusters", CLUSTERS)
@pytest.mark.parametrize("count", [
    pytest.param(1, marks=pytest.mark.sim), pytest.param(6 * NIGHTS, marks=pytest.mark.nightly)])
def test_words_of_tables_that_are_anything(clusters, count):
    """A load or a section ends all the same, with an error or without one; no byte beside the results is written, and
    the next job is right.
    """
    job, found = planned(clusters, cornell(clusters, points=POINTS[:2], sets="scheduled")), Counter()
    image, address, draw = job.phases[0].image, job.phases[0].address, random.Random(SEED)
    tables = {name: (address + image.offsets[name], image[name].nbytes) for name in image.regions
              if image[name].nbytes} | {"near cells": (int(job.descriptors["near_cells"][1]),
                                                      4 * int(job.descriptors["near_count"][1]))}
    with JobMachine(job, latency=3) as machine:
        for name, (first, size) in tables.items():
            for _ in range(count):
                machine.begin()
                for _ in range(draw.choice((1, 1, 3))):
                    value = draw.choice((0, 1, 0x7FFFFFFF, 0xFFFFFFFF, 1 << draw.randrange(32), draw.getrandbits(32)))
                    machine.write(first + draw.randrange(size // 4) * 4, value.to_bytes(4, "little"))
                machine(machine.host.write("watchdog", 20_000))
                machine.submit()
                records = machine.ended()
                machine(machine.host.write("watchdog", 1 << 20))
                if machine(machine.host.status())["halted"]:
                    # With the tables that are right, for the sections that are left.
                    machine.write(address, image.to_bytes())
                    records += machine.resumed()
                machine.check(np.array(records), codes(records), undefined=range(1, len(job.descriptors)))
                found[name, bool(codes(records))] += 1
                machine.right()
    assert any(is_noticed for _, is_noticed in found)


@pytest.mark.nightly
@pytest.mark.parametrize("clusters", CLUSTERS)
def test_ten_thousand_frusta_in_one_job(clusters):
    """No credit, tag or record is lost: what is left of it would be too little in the end."""
    job = planned(clusters, cornell(clusters, points=range(10), rays=(4, 4), cell=0.5, sets="scheduled"), ring_bits=4)
    with JobMachine(job) as machine:
        frusta, expected = job.descriptors[1:], machine.memory.expected.completions
        machine.begin()
        machine(machine.host.run(job, job.descriptors[:1]))
        records = machine(machine.host.run(job, np.tile(frusta, 1000)))
        assert (np.bincount(records["tag"])[1:] == 1000).all()
        assert not records["error"].any()
        assert (records["sums"] == expected["sums"][records["tag"]]).all()
        machine.right()
