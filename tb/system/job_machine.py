"""Machines that cast jobs: of two clusters for a commit's tests, of one for the nightly; each is compiled once."""

from collections.abc import Mapping

import numpy as np
import pytest

from golden.engine.jobs.job import Job, PhaseRequest, plan_job
from radiosity.flow.host import POLL, EngineError, Host
from radiosity.flow.simulator.simulated_port import SimulatedPort, complete
from tb.lib.configurations import config_of
from tb.system.checked_machine import checked_machine
from tb.system.job_memory import JobMemory
from tb.system.scenes import phase

__all__ = ["BASE", "CLUSTERS", "CONFIGS", "LISTS", "ONE_CLUSTER", "SHADOWS", "SMALL", "TWO_CLUSTERS", "JobMachine",
           "cornell", "planned"]

# Beyond 2^32.
BASE = 0x1_0000_4000
# Capacities for small frusta only: resident sets, stores, lists and caches are too small for the scene.
SMALL = {"icu.rays": 1024, "icu.side_bits": 6, "icu.patch_bits": 9, "icu.generation_bits": 2,
         "memsys.scene_cells": 1024, "memsys.own_cells": 64, "memsys.own_entries": 128, "memsys.own_patches": 16,
         "memsys.store_patches": 8, "memsys.store_requests": 4, "memsys.cell_lines": 8, "memsys.patch_lines": 8,
         "memsys.lfu_lines": 4, "memsys.cache_fetches": 2,
         "memsys.filter_generation_bits": 2, "memory.timeout_bits": 9, "ctu.ray_slots": 256, "ctu.grid_row_bits": 7,
         "ctu.grid_column_bits": 9, "ctu.shell_bits": 4, "ctu.near_cell_bits": 5, "noc.rows": 1}
# With shadow frusta of all sizes, and lists that are short for them.
SHADOWS = {"icu.shadow_bits": 7, "icu.side_bits": 8}
# With subshell lists.
LISTS = {"ctu.subshell_bits": 6}
CONFIGS = {clusters: config_of(SMALL | {"noc.columns": clusters}) for clusters in (1, 2)}
# For `pytest.mark.parametrize`: pytest-xdist runs the tests of one machine in one process, so that none waits for the
# compiler in another one.
CLUSTERS = [pytest.param(clusters, marks=[pytest.mark.xdist_group(f"machine {clusters}"),
                                          *([pytest.mark.nightly] if clusters == 1 else [])]) for clusters in CONFIGS]
ONE_CLUSTER, TWO_CLUSTERS = (one.marks[0] for one in CLUSTERS)
# Polls of a halted queue in which all records of what was in flight are written.
_RECORDS = 100
# Bytes around a job that must not change.
_MARGIN = 256


def cornell(clusters: int, /, **given) -> PhaseRequest:
    """`phase` of the scene `cornell` for one of `CONFIGS`; by default all patches are in main memory alone."""
    return phase("cornell", CONFIGS[clusters], **{"cell": 0.25, "rays": (32, 16), "sets": [()] * clusters} | given)


def planned(clusters: int, *requests: PhaseRequest, **given) -> Job:
    """`plan_job` for one of `CONFIGS`."""
    return plan_job(requests, CONFIGS[clusters], base=BASE, **given)


class JobMachine:
    """A simulated machine with its host, and a job in main memory. Around it are bytes that must not change.

    Parameters
    ----------
    job
        The job.
    descriptors
        Descriptors in place of the job's, see `run_job`.
    extra
        Byte strings in main memory behind the job, by address; the machine may access them.
    expected
        The results. Default: they are computed.
    memory
        Parameters of `SimulatedPort`. Default: the library of `checked_machine`.
    """

    def __init__(self, job: Job, descriptors: np.ndarray | None = None, *, extra: Mapping[int, bytes] | None = None,
                 expected: JobMemory | None = None, **memory):
        self.job, self.config, self._extra = job, job.config, dict(extra or {})
        self._end = max([job.end, *(address + len(data) for address, data in self._extra.items())])
        self._base = max(0, job.base - _MARGIN)
        self.port = SimulatedPort(self.config, size=self._end + _MARGIN - self._base, base=self._base,
                                  **{"library": memory.get("library") or checked_machine(self.config)} | memory)
        self.host = Host(self.port, self.config)
        self.memory = expected or JobMemory(job, descriptors)
        complete(self.host.identify())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.port.close()

    def __call__(self, coroutine):
        """The result of one of the host's coroutines."""
        return complete(coroutine)

    def read(self, address: int, size: int) -> bytes:
        """Bytes of main memory."""
        return complete(self.port.read_memory(address, size))

    def write(self, address: int, data: bytes) -> None:
        """Write bytes of main memory, which are to stay."""
        complete(self.port.write_memory(address, data))
        self._before[address - self._base:address - self._base + len(data)] = data

    def begin(self, **given) -> None:
        """Tables and images into main memory, whose other bytes are all the same; rings to the machine."""
        complete(self.port.write_memory(self._base, b"\xa5" * self.port.size))
        complete(self.host.begin(self.job, **{"window": (self.job.base, self._end)} | given))
        for address, data in self._extra.items():
            complete(self.port.write_memory(address, data))
        self._before = bytearray(self.read(self._base, self.port.size))
        self._taken = complete(self.host.read("taken"))

    def submit(self) -> None:
        """All descriptors, which the rings can hold."""
        complete(self.host.submit(self.job, self.memory.descriptors))

    def run(self, **given) -> np.ndarray:
        """The completion records of the job."""
        return complete(self.host.run(self.job, self.memory.descriptors, **given))

    def check(self, records: np.ndarray, errors=None, **given) -> None:
        """See `JobMemory.check`."""
        self.memory.check(self._before, self.read(self._base, self.port.size), records, base=self._base, errors=errors,
                          **given)
        assert self.port.outside == 0

    def right(self, errors=None, **given) -> np.ndarray:
        """The completion records of the job, from the beginning; all is as it should be."""
        self.begin(**given)
        records = self.run()
        self.check(records, errors)
        return records

    def until(self, name: str, value: int = 0, *, timeout: int = 1 << 18) -> None:
        """Wait until a bit of the machine's status has a value."""
        for _ in range(timeout // POLL):
            status = complete(self.host.status())
            if status[name] == value:
                return
            complete(self.port.wait(POLL))
        raise AssertionError(f"the status is {status} still")

    def ended(self, *, timeout: int = 1 << 18) -> list:
        """Wait until the queue has nothing to do, or has halted and a record cannot be written; the completion records
        since the last ones.
        """
        halted = 0
        for _ in range(timeout // POLL):
            status = complete(self.host.status())
            halted += status["halted"]
            if not status["busy"] or halted == _RECORDS:
                return [*complete(self.host.collect(self.job))]
            complete(self.port.wait(POLL))
        raise AssertionError(f"the status is {status} still")

    def resumed(self, *, attempts: int = 1) -> list:
        """Let a halted queue go on until it has nothing to do, with the image of the next section's phase: the loads
        that follow are of what their phases change. The completion records.

        Parameters
        ----------
        attempts
            Most loads until one succeeds.

        Raises
        ------
        EngineError
            The last one has failed.
        """
        taken = (complete(self.host.read("taken")) - self._taken) % (1 << 32)
        phase = next((one.phase for one in self.job.sections[taken:] if one), 0)
        for left in reversed(range(attempts)):
            try:
                complete(self.host.resume(self.job.phases[phase].address))
            except EngineError:
                if not left:
                    raise
            else:
                break
        self.until("busy")
        return [*complete(self.host.collect(self.job))]
