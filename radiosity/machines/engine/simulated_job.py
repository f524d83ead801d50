"""Simulated job: the cycles of a job on clusters that hold all patches, with the golden model's cells and tests."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.engine.cast.shelling import Shelling
from golden.engine.config import Config
from golden.engine.frustum.bundle import Bundle
from golden.engine.jobs.descriptor import list_words
from golden.engine.jobs.job import Job, PhaseRequest
from golden.engine.jobs.result_formats import bit_words
from radiosity.machines.engine.cast_store import CastStore
from radiosity.machines.engine.cluster_timing import ClusterTiming
from radiosity.machines.engine.job_queue import JobSections, JobTimes, run_queue
from radiosity.machines.engine.job_timing import JobTiming
from radiosity.machines.engine.load_cycles import LoadTiming, load_cycles
from radiosity.machines.engine.simulated_cast import SimulatedCast

__all__ = ["SimulatedJob", "phase_casts", "simulate_job"]


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedJob:
    """A job that has been simulated.

    Parameters
    ----------
    times
        The cycles of its events.
    casts
        The cast of each section, in the order of the queue.
    words, beats
        S int64: words of sums of each section, and beats of its hits and sums.
    """

    times: JobTimes
    casts: tuple[SimulatedCast, ...]
    words: np.ndarray
    beats: np.ndarray

    @property
    def tests(self) -> int:
        """Tests of all sections."""
        return sum(cast.tests for cast in self.casts)

    @property
    def cast_cycles(self) -> int:
        """Cycles of all casts together."""
        return sum(cast.times.cycles for cast in self.casts)


def phase_casts(request: PhaseRequest, config: Config, timing: ClusterTiming, *,
                folder: Path | None = None) -> CastStore:
    """The casts of a phase's sections, see `CastStore`.

    Parameters
    ----------
    request, config
        The phase, and the configuration of the machine.
    timing, folder
        See `CastStore`.
    """
    rays = len(request.records[0])
    # The golden model has the rays of whole frusta.
    whole = config.for_rays(rays)
    shelling = Shelling.of_cells(request.geometry, request.table, whole, by_code=True)
    return CastStore(shelling, whole, timing, folder=folder)


def simulate_job(job: Job, casts: CastStore, *, job_timing: JobTiming, load_timing: LoadTiming,
                 clusters: int | None = None,
                 note: Callable[[int], object] = lambda done: None) -> SimulatedJob:
    """Simulate a job of one phase, from the begin of the load to the last result.

    Parameters
    ----------
    job, casts
        The job, and the casts of its phase (`phase_casts`).
    job_timing, load_timing
        Latencies and capacities.
    clusters
        Clusters of the machine. Default: those of the job's configuration.
    note
        Called with the number of sections that have been cast, after each.

    Raises
    ------
    InputError
        The job has several phases, or its clusters do not hold all patches.
    """
    if len(job.phases) != 1 or not job.phases[0].image.has_copies:
        raise InputError("machines: A job must be of one phase whose patches every cluster holds")
    phase, config, made, near, rays, written = job.phases[0], job.config, [], [], [], []
    request = phase.request
    for one, words in zip(job.sections, list_words(job.descriptors), strict=True):
        if one is not None:
            section = one.section
            record = request.records[one.frustum]
            made.append(casts.cast(record, section))
            is_shadow = record.bundle == Bundle.SHADOW
            rays.append(max(1, len(section.among(record.listed, record))) if is_shadow else section.rays)
            written.append(8 * bit_words(rays[-1]) if is_shadow else section.rays * request.hit_format.bytes)
            near.append(words)
            note(len(made))
    rays, bits = np.array(rays), config.memory.data_bits
    hits = -(-8 * np.array(written) // bits)
    words = np.array([cast.hit for cast in made]) if request.sums else np.zeros_like(rays)
    sums = -(-64 * words // bits)
    times = run_queue(JobSections(
        near=np.array(near), free=np.array([cast.times.free for cast in made]),
        cycles=np.array([cast.times.cycles for cast in made]), rays=rays, hits=hits, sums=sums),
        job_timing, clusters=clusters or config.noc.clusters, load=load_cycles(phase.image, load_timing))
    return SimulatedJob(times=times, casts=tuple(made), words=words, beats=hits + sums)
