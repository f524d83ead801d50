"""The exported driver in C: what it does to a machine, and how it reads records."""

import ctypes
import subprocess

import numpy as np
import pytest

from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.jobs.completion import COMPLETION
from golden.engine.jobs.descriptor import DESCRIPTOR, load_descriptor
from golden.engine.jobs.result_formats import HitFormat, pack_bits, pack_hits, pack_sums
from hw.cluster import COUNTERS
from hw.registers.engine_registers import COUNTER_BITS, COUNTERS_BASE, ENGINE_REGISTERS
from hw.registers.error_code import ABOUT, ErrorCode
from hw.registers.register import WORD_BYTES, addresses
from radiosity.flow.package.plain_text import plain_text
from tb.radiosity.flow.package.driver_library import (
    FLAGS,
    Completion,
    Engine,
    Fault,
    Hit,
    JobPlace,
    build_driver,
    complaints,
)
from tb.radiosity.flow.package.register_machine import RegisterMachine

BUS, MAGIC_WRONG, VERSION_WRONG, ARGUMENT, FULL, HALTED, TIMEOUT, UNWRITTEN, LOST = range(-1, -10, -1)
RING_BITS, RING, COMPLETIONS, END = 2, 0x100, 0x400, 0x800
POLLS = 20


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("driver")


@pytest.fixture(scope="module")
def library(folder):
    return build_driver(folder)


@pytest.fixture
def machine():
    return RegisterMachine(END)


def place(**changes):
    given = {"base": 0x40, "end": END, "ring": RING, "completions": COMPLETIONS, "image": 0x1_2345_6780,
             "ring_bits": RING_BITS, "policy": 2, "copies": 1}
    return JobPlace(**(given | changes))


def unset():
    """An engine whose memory holds anything, as on a stack."""
    return Engine.from_buffer(bytearray(b"\xff" * ctypes.sizeof(Engine)))


def opened(library, machine):
    engine = unset()
    assert library.radiosity_open(ctypes.byref(engine), machine.port) == 0
    return engine


def begun(library, machine, **changes):
    engine = opened(library, machine)
    assert library.radiosity_begin(ctypes.byref(engine), ctypes.byref(place(**changes))) == 0
    return engine


def descriptors(*tags):
    return b"".join(load_descriptor(0, 0, tag=tag).tobytes() for tag in tags)


def submit(library, engine, *tags):
    return library.radiosity_submit(ctypes.byref(engine), descriptors(*tags), len(tags))


def wait(library, engine, polls=POLLS):
    record = Completion()
    return library.radiosity_wait(ctypes.byref(engine), ctypes.byref(record), polls), record


@pytest.mark.parametrize("file", ["use.cpp", "radiosity.c"])
def test_the_driver_is_cplusplus_too(file, folder, library):
    """Build systems that compile all sources alike give the C file to a C++ compiler."""
    (folder / "use.cpp").write_text('#include "radiosity.h"\nint main() { return !radiosity_error_name(0); }\n')
    assert not complaints(folder, "g++", "-x", "c++", "-std=c++11", *FLAGS[1:],
                          "-Wno-missing-field-initializers", "-fsyntax-only", file)


def test_nothing_is_allocated_and_no_library_is_needed(folder, library):
    done = subprocess.run(["nm", "--undefined-only", "-D", folder / "radiosity.so"], capture_output=True, text=True,
                          check=True)
    needed = {line.split()[-1].partition("@")[0] for line in done.stdout.splitlines()}
    assert needed <= {"__cxa_finalize", "__gmon_start__", "__stack_chk_fail", "memset", "memcpy",
                      "_ITM_deregisterTMCloneTable", "_ITM_registerTMCloneTable"}


@pytest.mark.parametrize(("name", "value", "result"), [
    ("magic", 0, MAGIC_WRONG), ("magic", 0xFFFF_FFFF, MAGIC_WRONG), ("version", 2, VERSION_WRONG),
    ("version", 4, VERSION_WRONG), ("clusters", 64, 0)])
def test_only_an_engine_of_this_version_is_opened(name, value, result, library, machine):
    machine.values[name] = value
    engine = unset()
    assert library.radiosity_open(ctypes.byref(engine), machine.port) == result
    assert engine.clusters == (machine.values["clusters"] if result == 0 else 0)


def test_begin_gives_the_machine_rings_and_windows(library, machine):
    machine.values |= {"taken": 7, "completed": 7, "doorbell": 9}
    machine.memory[:] = bytes([255]) * END
    begun(library, machine)
    assert {name: machine.values[name] for name in (
        "ring", "completions", "ring_bits", "read_base", "read_limit", "write_base", "write_limit", "policy",
        "doorbell")} == {
        "ring": RING, "completions": COMPLETIONS, "ring_bits": RING_BITS, "read_base": 0x40, "read_limit": END,
        "write_base": 0x40, "write_limit": END, "policy": 2, "doorbell": 7}
    entries = COMPLETION.dtype.itemsize << RING_BITS
    assert machine.memory == bytes([255]) * COMPLETIONS + bytes(entries) + bytes([255]) * (END - COMPLETIONS - entries)


@pytest.mark.parametrize("changes", [{"ring_bits": 32}, {"base": END + 1}])
def test_a_job_out_of_range_is_refused_before_anything_is_written(changes, library, machine):
    engine = opened(library, machine)
    machine.log.clear()
    assert library.radiosity_begin(ctypes.byref(engine), ctypes.byref(place(**changes))) == ARGUMENT
    assert machine.log == []


def test_addresses_have_two_words(library, machine):
    begun(library, machine, base=0, ring=0x12_3456_7000, end=0xFEDC_BA98_7654)
    assert machine.values["ring"] == 0x12_3456_7000
    assert machine.values["write_limit"] == 0xFEDC_BA98_7654


@pytest.mark.parametrize("start", [0, 3, (1 << 32) - 2])
def test_a_job_of_more_descriptors_than_the_ring_has_entries(start, library, machine):
    machine.values |= {"taken": start, "completed": start}
    engine, tags, found = begun(library, machine), list(range(10)), []
    while len(found) < 10:
        free = library.radiosity_free_entries(ctypes.byref(engine))
        given, tags = tags[:free], tags[free:]
        assert submit(library, engine, *given) == 0
        result, record = wait(library, engine)
        assert result == 1
        found.append(record.tag)
    assert found == list(range(10))
    assert machine.values["completed"] == (start + 10) % (1 << 32)
    assert wait(library, engine, 3)[0] == TIMEOUT


def test_more_descriptors_than_free_entries_are_refused(library, machine):
    engine = begun(library, machine)
    assert submit(library, engine, 0, 1, 2) == 0
    before = bytes(machine.memory)
    assert submit(library, engine, 3, 4) == FULL
    assert (machine.values["doorbell"], bytes(machine.memory)) == (3, before)
    assert submit(library, engine, 3) == 0


def test_the_image_is_copied_to_the_base(library, machine):
    engine, job, image = opened(library, machine), place(), bytes(range(256))
    assert library.radiosity_load_image(
        ctypes.byref(engine), ctypes.byref(job), image, ctypes.c_size_t(len(image))) == 0
    assert machine.memory[:0x40 + 256] == bytes(0x40) + image
    assert library.radiosity_load_image(
        ctypes.byref(engine), ctypes.byref(job), bytes(END), ctypes.c_size_t(END - 0x40 + 1)) == ARGUMENT
    # The whole window is not too much.
    most = bytes([7]) * (END - 0x40)
    assert library.radiosity_load_image(
        ctypes.byref(engine), ctypes.byref(job), most, ctypes.c_size_t(len(most))) == 0
    assert machine.memory == bytes(0x40) + most


def test_records_that_were_written_before_the_queue_halted_come_first(library, machine):
    engine = begun(library, machine)
    machine.errors[1] = ErrorCode.POINTER.value
    assert submit(library, engine, 0, 1) == 0
    assert (wait(library, engine)[0], machine.values["completed"]) == (1, 1)
    machine._complete()
    machine.halt(ErrorCode.PATH_BUS.value, 1, 0x12_3456_7890)
    result, record = wait(library, engine)
    assert (result, record.tag, record.error) == (1, 1, ErrorCode.POINTER.value)
    assert wait(library, engine)[0] == HALTED
    fault = Fault()
    assert library.radiosity_read_fault(ctypes.byref(engine), ctypes.byref(fault)) == 0
    assert (fault.error, fault.cluster, fault.address) == (ErrorCode.PATH_BUS.value, 1, 0x12_3456_7890)


def test_a_halt_is_reported_when_the_reset_is_over(library, machine):
    engine = begun(library, machine)
    machine.halt(ErrorCode.WATCHDOG.value, 0, 0)
    machine.status |= {"stops": 1, "busy": 1}
    assert wait(library, engine, 5)[0] == TIMEOUT
    machine.status["stops"] = 0
    assert wait(library, engine, 5)[0] == TIMEOUT
    machine.status["unwritten"] = 1
    assert wait(library, engine, 5)[0] == HALTED


def test_a_machine_that_was_reset_is_noticed(library, machine):
    machine.values |= {"taken": 5, "completed": 5}
    engine = begun(library, machine)
    machine.values["completed"] = 0
    assert wait(library, engine)[0] == LOST


@pytest.mark.parametrize("settles", [0, 6])
def test_a_reset_machine_casts_again(settles, library, machine):
    engine = begun(library, machine)
    assert submit(library, engine, 0, 1) == 0
    machine.halt(ErrorCode.RING.value, 0, 9)
    machine.settles = settles
    assert library.radiosity_reset(ctypes.byref(engine), POLLS) == 0
    assert machine.values["error"] == 0
    assert machine.status["halted"]
    assert library.radiosity_begin(ctypes.byref(engine), ctypes.byref(place())) == 0
    assert machine.values["doorbell"] == machine.values["taken"]
    assert library.radiosity_resume(ctypes.byref(engine), POLLS) == 0
    assert machine.values["image"] == 0x1_2345_6780
    assert ("write", "command", 0b1100) in machine.log, "copies accompanies resume"
    assert submit(library, engine, 8) == 0
    result, record = wait(library, engine)
    assert (result, record.tag) == (1, 8)


def test_a_reset_that_takes_too_long(library, machine):
    engine = begun(library, machine)
    machine.settles = POLLS
    assert library.radiosity_reset(ctypes.byref(engine), 5) == TIMEOUT
    machine.status |= {"unwritten": 1}
    assert library.radiosity_reset(ctypes.byref(engine), 2 * POLLS) == UNWRITTEN


def test_a_load_of_a_resume_that_fails(library, machine):
    engine = begun(library, machine, copies=0)
    machine.halt(ErrorCode.RING.value, 0, 9)
    machine.settles = POLLS
    assert library.radiosity_resume(ctypes.byref(engine), 3) == TIMEOUT
    assert ("write", "command", 0b100) in machine.log
    machine.settles = POLLS
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(machine, "_command", lambda value: machine.halt(ErrorCode.IMAGE.value, 0, 0))
        assert library.radiosity_resume(ctypes.byref(engine), 3) == HALTED


def test_interrupts_are_acknowledged_before_registers_are_read(library, machine):
    engine = begun(library, machine)
    assert library.radiosity_enable_interrupt(ctypes.byref(engine), 1) == 0
    assert submit(library, engine, 0) == 0
    machine.log.clear()
    assert wait(library, engine)[0] == 1
    acknowledge = ("write", "interrupt", 3)
    assert machine.log == [acknowledge, ("read", "status"), ("read", "completed"), ("wait", True),
                           acknowledge, ("read", "status"), ("read", "completed")]
    machine.status |= {"halted": 1, "stops": 1}
    machine.log.clear()
    assert wait(library, engine, 1)[0] == TIMEOUT
    assert ("wait", False) in machine.log, "no interrupt reports the end of a reset"
    assert library.radiosity_enable_interrupt(ctypes.byref(engine), 0) == 0
    assert machine.values["interrupt"] & 1 == 0


def test_every_error_of_the_port_is_reported(library, machine):
    """Whichever access of a job fails, it alone, its function returns BUS."""
    def cast():
        engine, record = unset(), Completion()
        pointer = ctypes.byref(engine)
        yield library.radiosity_open(pointer, machine.port)
        yield library.radiosity_load_image(pointer, ctypes.byref(place()), bytes(64), ctypes.c_size_t(64))
        yield library.radiosity_begin(pointer, ctypes.byref(place()))
        yield library.radiosity_enable_interrupt(pointer, 1)
        yield library.radiosity_submit(pointer, descriptors(3), 1)
        yield library.radiosity_wait(pointer, ctypes.byref(record), POLLS)
        yield library.radiosity_read_fault(pointer, ctypes.byref(Fault()))
        yield library.radiosity_read_counter(pointer, 0, 0, ctypes.byref(ctypes.c_uint32()))
        yield library.radiosity_reset(pointer, POLLS)
        yield library.radiosity_resume(pointer, POLLS)

    machine.broken = most = 100
    assert list(cast()) == [0, 0, 0, 0, 0, 1, 0, 0, 0, 0]
    accesses = most - machine.broken
    assert 50 < accesses < most
    for number in range(accesses):
        machine.__init__(END)
        machine.broken, results = number, []
        for result in cast():
            results.append(result)
            if machine.broken < 0:
                break
        assert results[-1] == BUS, f"access {number}"
        assert all(result in (0, 1) for result in results[:-1])


def test_counters_of_a_cluster(library, machine):
    engine, value = opened(library, machine), ctypes.c_uint32()
    for number, name in enumerate(COUNTERS):
        assert library.radiosity_read_counter(ctypes.byref(engine), 1, number, ctypes.byref(value)) == 0
        assert value.value == COUNTERS_BASE + WORD_BYTES * ((1 << COUNTER_BITS) + number)
        assert library.radiosity_counter_name(number).decode() == name
    for cluster, number in (2, 0), (0, len(COUNTERS)):
        assert library.radiosity_read_counter(
            ctypes.byref(engine), cluster, number, ctypes.byref(value)) == ARGUMENT
    assert library.radiosity_counter_name(len(COUNTERS)) == b"unknown"


def test_texts_are_those_of_the_tables(library):
    for one in ErrorCode:
        assert library.radiosity_error_name(one.value).decode() == one.name
        text = library.radiosity_error_text(one.value).decode()
        assert text.replace('"', '\\"') == plain_text(ABOUT[one.name])
        assert "](" not in text
    assert library.radiosity_error_name(63) == b"UNKNOWN"
    texts = [library.radiosity_result_text(result) for result in range(0, LOST - 1, -1)]
    assert len(set(texts)) == len(texts)
    assert b"unknown" not in texts
    assert library.radiosity_result_text(LOST - 1) == b"unknown"


def test_records_are_those_of_the_formats(library):
    random = np.random.default_rng(1)
    data = random.bytes(COMPLETION.dtype.itemsize)
    record, (expected,) = Completion(), np.frombuffer(data, dtype=COMPLETION.dtype)
    library.radiosity_unpack_completion(data, ctypes.byref(record))
    assert {field.name: getattr(record, field.name) for field in COMPLETION.fields} == {
        field.name: int(expected[field.name]) for field in COMPLETION.fields}


@pytest.mark.parametrize("hit_format", list(HitFormat)[1:])
def test_hits_are_those_of_the_formats(hit_format, library):
    random, wide = np.random.default_rng(1), hit_format == HitFormat.FULL
    bits = {"inverse": 32 if wide else 24, "u": 16 if wide else 8, "v": 16 if wide else 8}
    # All bits but one of a half, and the greatest numbers.
    most = (1 << 24) - 2 if hit_format == HitFormat.COMPACT else (1 << 31) - 2
    patches = np.array([-1, 0, 1, 0xFFFF, 0x5A_FFFF, 0xFF_0000, (1 << 24) - 2, most])
    hits = FixedHits(patch=patches, **{
        name: random.integers(1 << size, size=len(patches)) for name, size in bits.items()})
    for ray, data in enumerate(pack_hits(hits, hit_format)):
        hit = Hit()
        assert library.radiosity_unpack_hit(int(hit_format), data.tobytes() + bytes(8), ctypes.byref(hit)) == 0
        assert hit.patch == hits.patch[ray]
        expected = [0] * 3 if hit_format == HitFormat.IDS else [hits.inverse[ray], hits.u[ray], hits.v[ray]]
        assert [hit.inverse, hit.u, hit.v] == expected


@pytest.mark.parametrize("hit_format", [0, 4])
def test_other_formats_are_refused(hit_format, library):
    assert library.radiosity_unpack_hit(hit_format, bytes(16), ctypes.byref(Hit())) == ARGUMENT


def test_bits_are_those_of_the_format(library):
    blocked = np.random.default_rng(1).integers(2, size=130)
    assert [library.radiosity_unpack_bit(pack_bits(blocked), ray) for ray in range(130)] == blocked.tolist()


def test_sums_are_those_of_the_format(library):
    patches, sums = np.array([0, 7, (1 << 22) - 1]), np.array([(1 << 42) - 1, 1, 12345678901])
    for word, patch, value in zip(pack_sums(patches, sums), patches, sums, strict=True):
        found, total = ctypes.c_uint32(), ctypes.c_uint64()
        library.radiosity_unpack_sum(word.tobytes(), ctypes.byref(found), ctypes.byref(total))
        assert (found.value, total.value) == (patch, value)


def test_the_header_has_the_registers_and_the_size_of_a_descriptor(folder, library):
    lines = [f"_Static_assert(RADIOSITY_REG_{name.upper()} == {address}, \"{name}\");"
             for name, address in addresses(ENGINE_REGISTERS).items()]
    lines.append(f"_Static_assert(RADIOSITY_DESCRIPTOR_BYTES == {DESCRIPTOR.dtype.itemsize}, \"descriptor\");")
    lines += [f"_Static_assert(RADIOSITY_{one.name.upper()}_{field.name.upper()} == "
              f"{one.pack(**{field.name: (1 << field.width) - 1})}, \"{field.name}\");"
              for one in ENGINE_REGISTERS for field in one.fields]
    (folder / "constants.c").write_text("\n".join(['#include "radiosity.h"', *lines, ""]))
    assert not complaints(folder, "gcc", "-std=c11", *FLAGS[1:], "-fsyntax-only", "constants.c")
    (folder / "constants.c").write_text('#include "radiosity.h"\n_Static_assert(RADIOSITY_REG_MAGIC == 4, "magic");\n')
    assert "magic" in complaints(folder, "gcc", "-std=c11", *FLAGS[1:], "-fsyntax-only", "constants.c")
