"""A simulated machine with its host: requests of phases in, results of frusta and counters out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from golden.base.output import whole_file
from golden.engine.config import Config
from golden.engine.jobs.job import HeldTables, Job, PhaseRequest, plan_job
from hw.memsys.bus.cache_policy import CachePolicy
from radiosity.flow.host import Host, check_completions
from radiosity.flow.simulator.job_result import (
    OF_CACHES,
    SHARED_COUNTERS,
    SINCE_RESET,
    JobCycles,
    JobResult,
    cluster_counters,
    frustum_results,
    loads_scene,
)
from radiosity.flow.simulator.simulated_port import SimulatedPort, complete
from radiosity.flow.simulator.utilization import SAMPLED
from radiosity.flow.simulator.wave_view import write_wave_view

__all__ = ["SAMPLE_CYCLES", "SimulatedMachine", "WaveformWindow"]

# Cycles between two samples of the counters for a timeline.
SAMPLE_CYCLES = 200


@dataclass(frozen=True, kw_only=True)
class WaveformWindow:
    """The cycles whose signals are written as VCD.

    Parameters
    ----------
    path
        The file. A save file for GTKWave with the ports of the units is written beside it (.gtkw).
    begin
        First cycle, counted from the doorbell.
    cycles
        Number of cycles; the reads of a timeline's sample that begins in them are written to their end.
    """

    path: Path
    begin: int
    cycles: int


class SimulatedMachine:
    """The compiled RTL of an engine, its main memory and its host.

    Tables stay loaded from a job to the next; what differs is loaded.

    Parameters
    ----------
    config
        The configuration.
    policy
        The caches' policy. Default: the configuration's.
    memory
        Parameters of `SimulatedPort`: latency, spread, shuffles, seed, traced, library, progress.
    """

    def __init__(self, config: Config, *, policy: CachePolicy | None = None, **memory):
        self.config, self._policy = config, policy
        self.port = SimulatedPort(config, size=0, **memory)
        self._host = Host(self.port, config)
        self._held = HeldTables()
        complete(self._host.identify())

    def close(self) -> None:
        """Free the machine's memory."""
        self.port.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def run(self, requests: Sequence[PhaseRequest], *, timeline: list | None = None,
            waves: WaveformWindow | None = None, progress: Callable[[int], None] | None = None,
            ring_bits: int = 6) -> JobResult:
        """Cast the frusta of some phases as one job.

        Parameters
        ----------
        requests
            The phases, see `golden.engine.jobs.phase_request`.
        timeline
            A list to which samples are appended: the cycle since the doorbell, and the counters `SAMPLED` of each
            cluster. The first sample is of cycle 0, with ``waves`` too; the last one is of the end of the job, with
            all counters.
        waves
            The signals to write; needs ``traced``.
        progress
            Called with the number of descriptors that are complete.
        ring_bits
            Binary logarithm of the entries of the rings.

        Raises
        ------
        InputError
            See `golden.engine.jobs.job.plan_job`.
        EngineError
            A descriptor has ended in an error, or the queue has halted. The next job loads all tables.
        EngineTimeoutError
            See `Host.run`.
        """
        job = plan_job(requests, self.config, ring_bits=ring_bits, held=self._held)
        # Known again when the job has succeeded.
        self._held = HeldTables()
        self._begin(job)
        before = self._shared_counters(), complete(self._host.counters(SINCE_RESET))
        if timeline is not None:
            timeline.append((0, complete(self._host.counters(SAMPLED))))
        doorbell, first = complete(self._host.read("cycles")), self.port.cycles

        async def sample():
            cycle = self.port.cycles - first
            if timeline is not None and cycle >= timeline[-1][0] + SAMPLE_CYCLES:
                timeline.append((cycle, await self._host.counters(SAMPLED)))

        async def watch(completed):
            nonlocal waves
            if waves:
                window, waves = waves, None
                await self._write_waves(window, sample)
            await sample()
            if progress:
                progress(completed)

        records = complete(self._host.run(job, watch=watch))
        check_completions(job, records)
        result = self._result(job, records, doorbell, *before)
        self._held = job.held
        if timeline is not None:
            self._end_timeline(timeline, result)
        return result

    def _begin(self, job: Job):
        if job.end > self.port.size:
            self.port.resize(job.end)
        complete(self._host.begin(job, policy=self._policy))
        if complete(self._host.status())["halted"]:
            complete(self._host.resume(job.phases[0].address))

    async def _write_waves(self, window, sample):
        await self._wait(window.begin, sample)
        with whole_file(window.path) as part:
            self.port.trace(part)
            await self._wait(window.cycles, sample)
            self.port.trace(None)
        write_wave_view(window.path, window.path.with_suffix(".gtkw"))

    async def _wait(self, cycles, sample):
        end = self.port.cycles + cycles
        while (left := end - self.port.cycles) > 0:
            await self.port.wait(min(left, SAMPLE_CYCLES))
            if left > SAMPLE_CYCLES:
                await sample()

    def _result(self, job, records, doorbell, shared, counted):
        def read(address, size):
            return complete(self.port.read_memory(address, size))

        counters = cluster_counters(job, records, complete(self._host.counters()), counted)
        after = self._shared_counters()
        if loads_scene(job):
            shared = shared | dict.fromkeys(OF_CACHES, 0)
        return JobResult(job=job, frusta=frustum_results(job, records, read), records=records,
                         cycles=JobCycles.of(job, records, doorbell), counters=counters,
                         shared={name: after[name] - shared[name] for name in SHARED_COUNTERS})

    @staticmethod
    def _end_timeline(timeline, result):
        """The sample of the end; the counters of a sample that was being read at the end are the same."""
        while timeline and timeline[-1][0] >= result.cycles.total:
            timeline.pop()
        timeline.append((result.cycles.total, result.counters))

    def _shared_counters(self):
        return {name: complete(self._host.read(name)) for name in SHARED_COUNTERS}
