"""The host's driver at a machine that only has registers and rings."""

import asyncio
from itertools import pairwise

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.engine.jobs.completion import COMPLETION, lap
from golden.engine.jobs.descriptor import DESCRIPTOR, Kind
from golden.engine.jobs.job import plan_job
from hw.cluster import COUNTERS
from hw.memsys.bus.cache_policy import CachePolicy
from hw.registers.engine_registers import COUNTER_BITS, COUNTERS_BASE, ENGINE_REGISTERS, MAGIC, VERSION, register
from hw.registers.error_code import ErrorCode
from hw.registers.register import addresses
from radiosity.flow.host import POLL, EngineError, EngineTimeoutError, Host, Port, check_completions
from tb.golden.engine.jobs.jobs import CONFIG, job, requests

ADDRESSES = addresses(ENGINE_REGISTERS)
# Numbers of descriptors before the job: they wrap in it.
BEFORE = (1 << 32) - 3


class Queue(Port):
    """Registers and main memory, and a machine that completes some descriptors with each wait, the later ones first."""

    def __init__(self, size=1 << 22):
        self.values, self.memory, self.commands, self.waited = {}, bytearray(b"\xa5" * size), [], 0
        # What the register of the image held at each resume.
        self.resumed = []
        for name, value in (("magic", MAGIC), ("version", VERSION), ("clusters", 2), ("doorbell", BEFORE),
                            ("taken", BEFORE), ("completed", BEFORE)):
            self.set(name, value)
        # Descriptors per wait, and the tag after which the queue halts, with an error.
        self.speed, self.halts_at, self.code = 2, None, ErrorCode.PATH_TIMEOUT
        self.most = 0

    def set(self, name, value):
        """What a register holds."""
        for word in range(register(name).words):
            self.values[ADDRESSES[name] + 4 * word] = value >> 32 * word & 0xFFFFFFFF

    def get(self, name):
        """The same."""
        return sum(self.values.get(ADDRESSES[name] + 4 * word, 0) << 32 * word for word in range(register(name).words))

    async def read(self, address):
        return self.values.get(address, 0)

    async def write(self, address, value):
        if address == ADDRESSES["command"]:
            self.commands.append({name for name, bit in register("command").unpack(value).items() if bit})
            if "resume" in self.commands[-1]:
                self.resumed.append(self.get("image"))
        else:
            self.values[address] = value

    async def read_memory(self, address, size):
        return bytes(self.memory[address:address + size])

    async def write_memory(self, address, data):
        self.memory[address:address + len(data)] = data

    async def wait(self, cycles):
        self.waited += cycles
        taken = self.get("taken")
        count = (self.get("doorbell") - taken) % (1 << 32)
        self.most = max(self.most, count)
        for number in reversed(range(taken, taken + min(count, self.speed))):
            self._complete(number % (1 << 32))
        self.set("taken", (taken + min(count, self.speed)) % (1 << 32))

    def _complete(self, number):
        bits, done = self.get("ring_bits"), self.get("completed")
        entry = self.get("ring") + number % (1 << bits) * DESCRIPTOR.dtype.itemsize
        descriptor = np.frombuffer(self.memory, DESCRIPTOR.dtype, 1, entry)[0]
        record = np.zeros(1, COMPLETION.dtype)
        record["tag"], record["lap"], record["cluster"] = descriptor["tag"], lap(done, bits), 1
        if descriptor["tag"] == self.halts_at:
            record["error"], record["address"] = self.code.value, 99
            self.set("error", self.code.value)
            self.set("error_cluster", 1)
            self.set("error_address", 99)
            self.set("status", register("status").pack(halted=1, failed=1))
        elif self.get("error"):
            record["error"] = ErrorCode.ABORTED.value
        at = self.get("completions") + done % (1 << bits) * COMPLETION.dtype.itemsize
        self.memory[at:at + COMPLETION.dtype.itemsize] = record.tobytes()
        self.set("completed", (done + 1) % (1 << 32))


@pytest.fixture
def port():
    return Queue()


def run(coroutine):
    return asyncio.run(coroutine)


def begun(port, **given):
    """A host whose job has begun."""
    host = Host(port, CONFIG)
    run(host.begin(job(), **given))
    return host


def test_a_job_begins_with_its_tables_and_empty_rings(port):
    host = begun(port)
    for address, data in job().tables().items():
        assert bytes(port.memory[address:address + len(data)]) == data
    completions = slice(job().completions, job().completions + (64 << job().ring_bits))
    assert not any(port.memory[completions])
    assert {name: port.get(name) for name in ("ring", "completions", "ring_bits")} == {
        name: getattr(job(), name) for name in ("ring", "completions", "ring_bits")}
    for kind in "read", "write":
        assert (port.get(f"{kind}_base"), port.get(f"{kind}_limit")) == (job().base, job().end)
    assert port.get("policy") == CachePolicy[CONFIG.memsys.cache_policy.upper()].value
    assert host.free_entries(job()) == 8
    begun(port, window=(64, 1 << 40), policy=CachePolicy.DIRECT)
    assert (port.get("write_base"), port.get("read_limit"), port.get("policy")) == (64, 1 << 40, 0)


def test_all_descriptors_pass_a_ring_that_is_shorter(port):
    host, looks = begun(port), []

    async def watch(completed):
        looks.append((completed, port.get("doorbell")))

    records = run(host.run(job(), watch=watch))
    assert sorted(records["tag"]) == list(range(len(job().descriptors))), "pairs complete in exchanged order"
    assert records["tag"][:4].tolist() == [1, 0, 3, 2], "in the order of completion"
    assert port.get("doorbell") == (BEFORE + len(job().descriptors)) % (1 << 32)
    assert port.most == 8, "the ring is full"
    # The first look is behind the first doorbell.
    assert looks[0] == (0, (BEFORE + 8) % (1 << 32))
    assert all(before <= after for (before, _), (after, _) in pairwise(looks))


def test_other_descriptors_and_single_submissions(port):
    host, two = begun(port), job().descriptors[[3, 1]]
    assert sorted(run(host.run(job(), two))["tag"]) == [1, 3]
    run(host.submit(job(), list(two)))
    assert host.free_entries(job()) == 6
    assert len(run(host.collect(job()))) == 0
    run(port.wait(1))
    assert sorted(run(host.collect(job()))["tag"]) == [1, 3]
    assert host.free_entries(job()) == 8


def test_records_that_come_while_the_host_reads(port):
    """A record that is counted is read."""
    host, read = begun(port), port.read

    async def meanwhile(address):
        if address == ADDRESSES["completed"]:
            await port.wait(1)
        return await read(address)

    port.read = meanwhile
    records = run(host.run(job()))
    assert sorted(records["tag"]) == list(range(len(job().descriptors))), "pairs complete in exchanged order"


def test_a_machine_that_was_reset_is_refused(port):
    """Its counts begin at 0; what is submitted counts on from before."""
    host = begun(port)
    run(host.submit(job(), job().descriptors[:2]))
    port.set("completed", 0)
    with pytest.raises(InputError, match=r"completed must be at most 4294967295, not 0: it was reset"):
        run(host.collect(job()))


@pytest.mark.parametrize(("name", "message"), [("magic", "magic must be"), ("version", "version must be"),
                                               ("clusters", "clusters must be 0x2, not 0x7")])
def test_another_machine_is_refused(port, name, message):
    run(Host(port, CONFIG).identify())
    port.set(name, 7)
    with pytest.raises(InputError, match=message):
        run(Host(port, CONFIG).identify())


def test_a_queue_that_halts_is_an_error_that_names_the_frustum(port):
    host, port.halts_at = begun(port), 5
    one = job().sections[5]
    with pytest.raises(EngineError, match=rf"^frustum {one.frustum} of phase 0, columns {one.section.first_column} to "
                       r".*: PATH_TIMEOUT: a reply .* \(cluster 1, at 0x63\)$") as raised:
        run(host.run(job()))
    assert "\n" not in str(raised.value)
    assert (raised.value.code, raised.value.cluster, raised.value.address) == (ErrorCode.PATH_TIMEOUT, 1, 99)
    # What has not been taken is not taken by the next job.
    port.set("status", 0)
    begun(port)
    assert port.get("doorbell") == port.get("taken")


def test_a_record_that_comes_just_before_the_halt_names_the_frustum(port):
    """It is written after the host has looked for records, and before it reads the status."""
    host, port.halts_at, port.speed = begun(port), 5, 0
    read = port.read

    async def meanwhile(address):
        if address == ADDRESSES["status"] and not port.get("error"):
            port.speed = 2
            await port.wait(0)
            port.speed = 0
        return await read(address)

    port.read = meanwhile
    with pytest.raises(EngineError, match=rf"^frustum {job().sections[5].frustum} of phase 0, columns .*PATH_TIMEOUT"):
        run(host.run(job()))
    assert port.get("completed") == (BEFORE + 6) % (1 << 32)


def test_records_of_the_same_error_without_a_section_are_not_named(port):
    """A tag beyond the job's descriptors, as memory that was overwritten has, is no reason to fail."""
    host, port.halts_at = begun(port), 1000
    one = job().descriptors[3:4].copy()
    one["tag"] = 1000
    with pytest.raises(EngineError, match=r"^PATH_TIMEOUT: "):
        run(host.run(job(), one.repeat(2)))


def test_a_queue_that_halts_by_itself_is_an_error(port):
    host = begun(port)
    for name, value in ("error", ErrorCode.RING.value), ("error_address", 9):
        port.set(name, value)
    port.set("status", register("status").pack(halted=1, failed=1, busy=1))
    port.speed = 0
    original = port.wait

    async def wait(cycles):
        """Descriptors in flight end before the error is reported."""
        await original(cycles)
        if port.waited >= 3 * POLL:
            port.set("status", register("status").pack(halted=1, failed=1))

    port.wait = wait
    with pytest.raises(EngineError, match=r"^RING: the doorbell is .* \(cluster 0, at 0x9\)$"):
        run(host.run(job()))
    assert port.waited == 3 * POLL


def test_a_record_that_cannot_be_written_is_an_error_at_once(port):
    """The queue has halted and stays busy; while units are in reset the error is not complete."""
    host, port.speed = begun(port), 0
    for name, value in ("error", ErrorCode.WRITE_REPLY.value), ("error_address", 64):
        port.set(name, value)
    original = port.wait

    async def wait(cycles):
        await original(cycles)
        port.set("status", register("status").pack(
            halted=1, failed=1, busy=1, unwritten=1, stops=port.waited < 3 * POLL))

    port.wait = wait
    with pytest.raises(EngineError, match=rf"^completion record {BEFORE} cannot be written: WRITE_REPLY: main memory "
                       r"has answered a write with .* \(cluster 0, at 0x40\)$"):
        run(host.run(job()))
    assert port.waited == 3 * POLL


def test_records_with_errors_are_a_line_each():
    records = np.zeros(4, COMPLETION.dtype)
    records["tag"], records["cluster"] = [0, 2, 3, 1], [0xFF, 1, 0, 1]
    check_completions(job(), records)
    records["error"][2:], records["address"][2] = [ErrorCode.OVERFLOW.value, ErrorCode.NOT_LOADED.value], 7
    with pytest.raises(EngineError, match=r"^frustum \d of phase 0, columns \d+ to \d+, rows \d+ to \d+: OVERFLOW: the "
                       r"sum .* \(cluster 0, at 0x7\)$"):
        check_completions(job(), records)
    records["error"][0] = ErrorCode.IMAGE.value
    with pytest.raises(EngineError, match=r"^load of tables: IMAGE: .* \(no cluster, at 0x0\)$"):
        check_completions(job(), records)
    # Of a job of one phase the phase need not be named.
    made = plan_job(requests()[:1], CONFIG)
    with pytest.raises(EngineError, match=r"^frustum \d, columns"):
        check_completions(made, records[2:])


def test_an_endless_job_times_out(port):
    host, port.speed = begun(port), 0
    with pytest.raises(EngineTimeoutError, match="completed 0 of 18 descriptors, and none for 5000 cycles"):
        run(host.run(job(), timeout=5000))
    assert len(job().descriptors) == 18


def test_a_job_whose_clusters_stop_times_out_after_its_last_record(port):
    """Not before: the limit is that of the cycles without a record."""
    host, port.speed = begun(port), 1
    original = port.wait

    async def wait(cycles):
        port.speed = int(len(records) < 9 and port.waited // POLL % 3 == 2)
        before = port.get("completed")
        await original(cycles)
        records.extend(range((port.get("completed") - before) % (1 << 32)))

    records, port.wait = [], wait
    with pytest.raises(EngineTimeoutError, match=r"completed 9 of 18 descriptors, and none for 400 cycles"):
        run(host.run(job(), timeout=4 * POLL))
    assert port.waited > 9 * 3 * POLL


def resumes(port, **ends):
    """The status of a queue that is halted, loads from cycle 300 on, and ends so at cycle 700."""
    original, port.values[ADDRESSES["status"]] = port.wait, register("status").pack(halted=1)

    async def wait(cycles):
        await original(cycles)
        if port.waited >= 300:
            port.set("status", register("status").pack(**{"busy": 1, "loading": 1} if port.waited < 700 else ends))

    port.wait = wait


def test_a_halted_queue_is_resumed_from_an_image(port):
    host, (phase, *_) = begun(port), job().phases
    resumes(port, loaded=1)
    run(host.resume(phase.address))
    assert port.waited == 700, "the load has ended"
    assert port.resumed == [phase.address]
    # Every cluster holds all patches of the scene: the tables of the first one are for all.
    assert port.commands == [{"clear"}, {"resume", "copies"}]


def test_images_of_earlier_jobs_keep_their_copies(port):
    host = begun(port)
    run(host.begin(plan_job(requests()[:1], CONFIG, base=job().end)))
    resumes(port, loaded=1)
    run(host.resume(job().phases[0].address))
    assert port.commands[-1] == {"resume", "copies"}


def test_a_resume_that_fails_or_never_ends(port):
    host = begun(port)
    port.set("status", register("status").pack(halted=1))
    with pytest.raises(EngineTimeoutError, match="still halted after 2000 cycles"):
        run(host.resume(64, timeout=2000))
    assert port.commands[-1] == {"resume"}, "no image of a job"
    port.set("status", register("status").pack(halted=1, failed=1))
    port.set("error", ErrorCode.IMAGE.value)
    with pytest.raises(EngineError, match=r"^IMAGE: "):
        run(host.resume(64))


def test_a_resume_whose_load_fails_or_never_ends(port):
    host = begun(port)
    resumes(port, halted=1, failed=1)
    with pytest.raises(EngineTimeoutError, match="still loading after 500 cycles"):
        run(host.resume(64, timeout=500))
    port.set("error", ErrorCode.READ_REPLY.value)
    with pytest.raises(EngineError, match=r"^READ_REPLY: "):
        run(host.resume(64))


@pytest.mark.parametrize(("name", "most"), [("ring", (1 << 64) - 1), ("doorbell", (1 << 32) - 1), ("policy", 3),
                                            ("ring_bits", 31), ("image", (1 << 64) - 1)])
def test_registers_hold_what_is_written(port, name, most):
    host = Host(port, CONFIG)
    run(host.write(name, most))
    assert run(host.read(name)) == most
    # Each word of a small value replaces that of the large one.
    run(host.write(name, 1))
    assert run(host.read(name)) == 1
    for value in -1, most + 1:
        with pytest.raises(ValueError, match=f"{name} must be from 0 to {most}, not {value}"):
            run(host.write(name, value))


def test_counters_of_each_cluster(port):
    for cluster in range(2):
        for index in range(len(COUNTERS)):
            port.values[COUNTERS_BASE + 4 * ((cluster << COUNTER_BITS) + index)] = 100 * cluster + index
    found = run(Host(port, CONFIG).counters())
    assert found == [{name: 100 * cluster + index for index, name in enumerate(COUNTERS)} for cluster in range(2)]
    name = next(reversed(COUNTERS))
    assert run(Host(port, CONFIG).counters([name])) == [{name: found[0][name]}, {name: found[1][name]}]


def test_loads_and_sections_are_in_the_job():
    assert list(job().descriptors["kind"]).count(Kind.LOAD) == 3
