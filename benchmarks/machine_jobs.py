"""Whole jobs, simulated beside those of the hardware that docs/figures/job-cycles.csv has."""

import csv
from collections.abc import Iterator
from dataclasses import dataclass

from benchmarks.engine import LATENCY, POINT
from golden.engine.config import PRESETS, Config
from golden.engine.jobs.job import plan_job
from golden.engine.jobs.result_formats import HitFormat
from radiosity.flow.simulator.simulation_config import simulation_config
from radiosity.flow.synthesis.history import ROOT
from radiosity.machines.engine.cluster_latencies import cluster_timing
from radiosity.machines.engine.job_latencies import job_timing, load_timing
from radiosity.machines.engine.job_runs import JobSpec, prepare_job
from radiosity.machines.engine.simulated_job import SimulatedJob, phase_casts, simulate_job

__all__ = ["RecordedJob", "job_config", "recorded_jobs", "simulate"]

_RECORDED = ROOT / "docs" / "figures" / "job-cycles.csv"

@dataclass(frozen=True, kw_only=True)
class RecordedJob:
    """A job of the hardware: preset ``paper``, sums written, each frustum a section.

    Parameters
    ----------
    spec
        What it casts; a single frustum is that from point `POINT`.
    clusters
        Clusters of the machine.
    cycles, load, cast
        Cycles of the job, of its load, and those in which a cluster casts, on average.
    """

    spec: JobSpec
    clusters: int
    cycles: int
    load: int
    cast: int


def recorded_jobs() -> tuple[RecordedJob, ...]:
    """All of them."""
    with _RECORDED.open(newline="") as file:
        return tuple(_recorded(row) for row in csv.DictReader(file))


def _recorded(row):
    frusta = int(row["frusta"])
    spec = JobSpec(scene=row["scene"], rays=(int(row["azimuths"]), int(row["polars"])), frusta=frusta,
                   point=POINT if frusta == 1 else None, cell=float(row["cell"]),
                   hit_format=HitFormat[row["hits"].upper()])
    return RecordedJob(spec=spec, **{name: int(row[name]) for name in ("clusters", "cycles", "load", "cast")})


def job_config(recorded: RecordedJob) -> Config:
    """The configuration of the machine, whose clusters have memory for 4096 patches."""
    azimuths, polars = recorded.spec.rays
    return simulation_config(PRESETS["paper"].replace({"memsys.own_patches": 4096}), clusters=recorded.clusters,
                             topology="mesh", rays=azimuths * polars)


def simulate(jobs: tuple[RecordedJob, ...]) -> Iterator[tuple[RecordedJob, SimulatedJob]]:
    """Each job, simulated."""
    for one in jobs:
        config = job_config(one)
        request = prepare_job(one.spec, config).request
        yield one, simulate_job(
            plan_job([request], config), phase_casts(request, config, cluster_timing(config)),
            job_timing=job_timing(config, latency=LATENCY), load_timing=load_timing(config, latency=LATENCY))
