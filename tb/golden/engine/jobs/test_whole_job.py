"""Main memory before the doorbell: the bytes that the driver of the simulations writes."""

import asyncio

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.engine.jobs.completion import COMPLETION
from golden.engine.jobs.descriptor import DESCRIPTOR
from golden.engine.jobs.job import plan_job
from golden.engine.jobs.whole_job import memory_before, whole_job
from hw.registers.engine_registers import ENGINE_REGISTERS
from hw.registers.register import addresses
from radiosity.flow.host import Host, Port
from tb.golden.engine.jobs.jobs import CONFIG, requests

BASE = 0x12340


class Memory(Port):
    """Main memory beside a machine that has just been reset and takes nothing."""

    def __init__(self, size):
        self.data = bytearray(size)

    async def read(self, address):
        return 0

    async def write(self, address, value):
        assert address in addresses(ENGINE_REGISTERS).values() or address - 4 in addresses(ENGINE_REGISTERS).values()

    async def read_memory(self, address, size):
        return bytes(self.data[address:address + size])

    async def write_memory(self, address, data):
        self.data[address:address + len(data)] = data

    async def wait(self, cycles):
        raise AssertionError


def test_it_is_what_the_driver_writes():
    job = whole_job(requests(), CONFIG, base=BASE)
    before = memory_before(job)
    port = Memory(job.end)

    async def prepare():
        host = Host(port, CONFIG)
        await host.begin(job)
        await host.submit(job, job.descriptors)

    asyncio.run(prepare())
    assert job.base == BASE == job.ring
    assert before == bytes(port.data[job.base:job.base + len(before)])
    assert not any(port.data[job.base + len(before):]), "results alone lie behind it"


def test_rings_have_an_entry_for_each_descriptor_and_no_more_than_twice_as_many():
    job = whole_job(requests(), CONFIG)
    assert len(job.descriptors) <= 1 << job.ring_bits < 2 * len(job.descriptors)
    size = DESCRIPTOR.dtype.itemsize
    ring = np.frombuffer(memory_before(job)[:size * len(job.descriptors)], dtype=DESCRIPTOR.dtype)
    assert ring["tag"].tolist() == list(range(len(job.descriptors)))
    entries = COMPLETION.dtype.itemsize << job.ring_bits
    first = job.completions - job.base
    assert not any(memory_before(job)[first:first + entries])


def test_a_job_beyond_the_addresses_is_refused():
    config = CONFIG.replace({"memory.address_bits": 20})
    end = whole_job(requests(), config).end
    assert whole_job(requests(), config, base=(1 << 20) - end).end == 1 << 20
    with pytest.raises(InputError, match=r"^job: Memory must end at 0x100000 \(memory.address_bits\), not 0x100040$"):
        whole_job(requests(), config, base=(1 << 20) - end + 64)


def test_a_ring_that_is_too_small_is_refused():
    with pytest.raises(ValueError, match=r"^The ring must have \d+ entries, not 2$"):
        memory_before(plan_job(requests(), CONFIG, ring_bits=1))
