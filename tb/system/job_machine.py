"""Machines with a queue, of two clusters for a commit's tests, of one for the nightly; each is compiled once."""

import numpy as np
import pytest

from golden.jobs.job import Job
from golden.jobs.run_job import run_job
from hw.host import Host
from hw.simulator.machine_library import machine_library
from hw.simulator.simulated_port import SimulatedPort, complete
from tb.lib.configurations import config_of
from tb.system.small_machine import SMALL

__all__ = ["CLUSTERS", "CONFIGS", "JobMachine"]

# Resident sets, lists and caches are too small for the scene.
CONFIGS = {clusters: config_of(SMALL | {"noc.columns": clusters}) for clusters in (1, 2)}
# A commit's tests compile the machine of two clusters alone.
CLUSTERS = [pytest.param(clusters, marks=[pytest.mark.xdist_group(f"queue {clusters}"),
                                          *([pytest.mark.nightly] if clusters == 1 else [])]) for clusters in CONFIGS]


class JobMachine:
    """A simulated machine with a queue, its host, and the memory of one job.

    Parameters
    ----------
    job
        The job, of the configuration of one of `CONFIGS`.
    memory
        Parameters of `SimulatedPort`.
    """

    def __init__(self, job: Job, **memory):
        self.config = job.config
        self.job = job
        self.port = SimulatedPort(self.config, size=job.end, library=machine_library(self.config), **memory)
        self.host = Host(self.port, self.config)
        complete(self.host.identify())
        self._before = bytearray(b"\xa5" * job.end)
        complete(self.port.write_memory(0, bytes(self._before)))
        self._expected = run_job(job)

    def image(self, phase: int = 0) -> int:
        """Address of the image of a phase."""
        return self.job.phases[phase].address

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.port.close()

    def begin(self) -> None:
        """Tables into main memory, rings to the machine."""
        complete(self.host.begin(self.job))
        self._before = bytearray(complete(self.port.read_memory(0, self.port.size)))

    def run(self, descriptors: np.ndarray | None = None, **given) -> np.ndarray:
        """The completion records of the job, or of these descriptors."""
        return complete(self.host.run(self.job, descriptors, **given))

    async def until(self, condition, *, timeout: int = 1 << 18) -> None:
        """Wait until the machine's status meets a condition."""
        for _ in range(timeout // 100):
            if condition(await self.host.status()):
                return
            await self.port.wait(100)
        raise AssertionError(f"the status is {await self.host.status()} still")

    def check(self, records, *, refused=(), aborted=()) -> None:
        """Hits, sums and the number of sums are golden's, and no other byte has changed.

        Parameters
        ----------
        records
            The completion records.
        refused, aborted
            Tags of sections of which nothing, or a part, may have been written.
        """
        found = bytes(complete(self.port.read_memory(0, self.port.size)))
        expected, job = bytearray(self._before), self.job
        for first, size in ((job.ring, 192 << job.ring_bits), (job.completions, 64 << job.ring_bits)):
            expected[first:first + size] = found[first:first + size]
        without, partly = ({address for tag in tags for address in self._addresses(tag)} for tags in (refused, aborted))
        for address, data in self._expected.memory.items():
            extent = slice(address, address + len(data))
            if address in partly:
                both = zip(found[extent], data, expected[extent], strict=True)
                assert all(now in (new, old) for now, new, old in both), f"results at {address:#x}"
                expected[extent] = found[extent]
            elif address not in without:
                expected[extent] = data
        wrong = np.flatnonzero(np.frombuffer(found, np.uint8) != np.frombuffer(expected, np.uint8))
        assert not len(wrong), f"{len(wrong)} bytes of main memory are wrong, the first at {wrong[0]:#x}"
        for record in records:
            tag = int(record["tag"])
            if tag not in (*refused, *aborted):
                assert record["error"] == 0, f"descriptor {tag} must complete without an error, not {record['error']}"
                assert record["sums"] == self._expected.completions["sums"][tag], f"words of sums of section {tag}"
        assert self.port.outside == 0

    def _addresses(self, tag):
        """Of the results of a section: where golden's extents begin."""
        descriptor = self.job.descriptors[tag]
        if descriptor["sums"]:
            yield int(descriptor["sums_address"])
        size = {0: 0, 1: 16, 2: 8, 3: 4}[int(descriptor["hit_format"])]
        if size:
            columns = int(descriptor["columns"])
            for row in range(int(descriptor["first_row"]), int(descriptor["end_row"])):
                yield int(descriptor["hits"]) + size * (row * columns + int(descriptor["first_column"]))
