"""The exported driver in C at the simulated machine: whole jobs, and a reset in the middle of one."""

import ctypes
import itertools

import pytest

from golden.engine.jobs.completion import parse_completions
from golden.engine.jobs.descriptor import DESCRIPTOR
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.jobs.whole_job import memory_before, whole_job
from hw.cluster import COUNTERS
from hw.memsys.bus.cache_policy import CachePolicy
from radiosity.flow.host import POLL
from radiosity.flow.simulator.simulated_port import complete
from tb.radiosity.flow.package.driver_library import Completion, Engine, JobPlace, PortFunctions, build_driver
from tb.system.job_machine import BASE, CONFIGS, TWO_CLUSTERS, JobMachine, cornell

pytestmark = TWO_CLUSTERS
CLUSTERS, POLLS = 2, 10_000
LOAD = DESCRIPTOR.dtype.itemsize


class Driven:
    """The driver at a machine that has just been reset, with a job in main memory.

    Members
    -------
    records
        The bytes of all completion records that the driver has read.
    """

    def __init__(self, library, machine, job):
        self._library, self._port, self.job, self.records = library, machine.port, job, []
        self._functions = PortFunctions(None, *(
            kind(function) for (_, kind), function in zip(PortFunctions._fields_[1:], (
                self._read, self._write, self._read_memory, self._write_memory, self._wait), strict=True)))
        phase, = job.phases
        self._place = JobPlace(
            base=job.base, end=job.end, ring=job.ring, completions=job.completions, image=phase.address,
            ring_bits=job.ring_bits, policy=CachePolicy.LRU.value, copies=int(phase.image.has_copies))
        self._engine = Engine()

    def __call__(self, name, *arguments):
        """What a function of the driver returns."""
        return getattr(self._library, f"radiosity_{name}")(ctypes.byref(self._engine), *arguments)

    def _read(self, context, address, value):
        value[0] = complete(self._port.read(address))
        return 0

    def _write(self, context, address, value):
        complete(self._port.write(address, value))
        return 0

    def _read_memory(self, context, address, data, size):
        found = complete(self._port.read_memory(address, size))
        self.records.append(found)
        ctypes.memmove(data, found, size)
        return 0

    def _write_memory(self, context, address, data, size):
        complete(self._port.write_memory(address, ctypes.string_at(data, size)))
        return 0

    def _wait(self, context, is_interrupt):
        complete(self._port.wait(POLL))
        return 0

    def begin(self):
        """Open, load and begin."""
        data = memory_before(self.job)
        assert self("open", ctypes.byref(self._functions)) == 0
        assert self("load_image", ctypes.byref(self._place), data, ctypes.c_size_t(len(data))) == 0
        assert self("begin", ctypes.byref(self._place)) == 0

    def begin_again(self):
        """After a reset."""
        assert self("begin", ctypes.byref(self._place)) == 0
        assert self("resume", POLLS) == 0

    def submit(self, *, first=0):
        """All descriptors from one on; their number."""
        data = self.job.descriptors[first:].tobytes()
        assert self("submit", data, len(data) // LOAD) == 0
        return len(data) // LOAD

    def wait(self, count):
        """The tags of so many completion records."""
        tags = []
        for _ in range(count):
            record = Completion()
            assert self("wait", ctypes.byref(record), POLLS) == 1
            tags.append(record.tag)
        return tags


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    return build_driver(tmp_path_factory.mktemp("driver"))


@pytest.fixture(scope="module")
def job():
    """Hemispheres of more sections than clusters, with hits and sums."""
    request = cornell(CLUSTERS, hit_format=HitFormat.COMPACT, sums=True, clusters=4)
    return whole_job([request], CONFIGS[CLUSTERS], base=BASE)


def checked(machine, driven):
    machine.check(parse_completions(b"".join(driven.records)))


def test_a_job_is_cast(library, job):
    with JobMachine(job) as machine:
        machine.begin()
        driven = Driven(library, machine, job)
        driven.begin()
        assert sorted(driven.wait(driven.submit())) == list(range(len(job.descriptors)))
        checked(machine, driven)
        value = ctypes.c_uint32()
        for cluster, (number, name) in itertools.product(range(CLUSTERS), enumerate(COUNTERS)):
            assert driven("read_counter", cluster, number, ctypes.byref(value)) == 0
            assert value.value == complete(machine.host.counters())[cluster][name]


def test_a_job_is_cast_after_a_reset_in_the_middle_of_another_one(library, job):
    with JobMachine(job) as machine:
        machine.begin()
        driven = Driven(library, machine, job)
        driven.begin()
        driven.submit()
        assert driven.wait(1) == [0]
        assert driven("reset", POLLS) == 0
        driven.begin_again()
        driven.records.clear()
        # The load of the resume has all tables: sections alone follow, then the whole job.
        sections = driven.submit(first=1)
        assert sorted(driven.wait(sections)) == list(range(1, len(job.descriptors)))
        driven.records.clear()
        assert sorted(driven.wait(driven.submit())) == list(range(len(job.descriptors)))
        checked(machine, driven)


def test_status_shows_the_effect_of_a_command_when_its_write_has_been_answered(library, job):
    with JobMachine(job) as machine:
        driven = Driven(library, machine, job)
        driven.begin()
        complete(machine.host.command("stop"))
        assert complete(machine.host.status())["halted"] == 1
        driven.begin()
        assert driven("resume", POLLS) == 0
        assert complete(machine.host.status())["halted"] == 0
