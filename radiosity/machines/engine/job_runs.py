"""Jobs of hemispheres from a scene's ceiling on the simulated machine: cycles, bounds and counters."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.cast.shelling import Shelling
from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord, hemisphere_record
from golden.engine.jobs.completion import patch_sources
from golden.engine.jobs.descriptor import Kind
from golden.engine.jobs.job import PhaseRequest
from golden.engine.jobs.phase_request import phase_request
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.ceiling_points import ceiling_points
from golden.engine.schedule.cell_choice import choose_cell
from golden.engine.schedule.job_shelling import job_shelling
from golden.scene.open import open_scene
from golden.scene.scene import Scene
from radiosity.flow.simulator.job_result import JobResult
from radiosity.flow.simulator.simulated_machine import SimulatedMachine
from radiosity.flow.simulator.simulated_port import complete

__all__ = ["JobRun", "JobSpec", "PreparedJob", "check_results", "job_machine", "prepare_job", "run_on"]

# The engine's cycle counter wraps.
_WRAP = 1 << 32
# Frusta from which the cell size is chosen; rays of a frustum for each one that a schedule casts.
_PREDICTED, _RATIO = 4, 16
# Binary logarithm of the rings' entries.
_RING_BITS = 8


@dataclass(frozen=True, kw_only=True)
class JobSpec:
    """What a job casts.

    Parameters
    ----------
    scene
        Name of the scene.
    rays
        Azimuths and polar angles of each hemisphere.
    frusta
        Hemispheres: at the first points of the ceiling, which has a power of two of them.
    point
        Only the hemisphere at this one of the ceiling's 16 points, instead of ``frusta``.
    cell
        Size of the cells. Default: chosen for the job.
    hit_format, sums, group
        See `golden.engine.jobs.job.PhaseRequest`; ``group`` is its ``clusters``.
    """

    scene: str
    rays: tuple[int, int] = (256, 64)
    frusta: int = 247
    point: int | None = None
    cell: float | None = None
    hit_format: HitFormat = HitFormat.NONE
    sums: bool = True
    group: int = 1


@dataclass(frozen=True, kw_only=True, eq=False)
class PreparedJob:
    """A job of one phase.

    Parameters
    ----------
    scene, cell
        What is cast into, and the size of its cells.
    request
        What the host requests.
    """

    scene: Scene
    cell: float
    request: PhaseRequest

    @property
    def records(self) -> Sequence[FrustumRecord]:
        """The frusta."""
        return self.request.records


def prepare_job(spec: JobSpec, config: Config) -> PreparedJob:
    """The job for a machine of a configuration.

    Raises
    ------
    InputError
        The scene has no ceiling, or the machine is too small for the job.
    """
    scene, hemisphere = open_scene(spec.scene), Hemisphere(*spec.rays)
    count = 16 if spec.point is not None else 1 << (spec.frusta - 1).bit_length()
    points, down = ceiling_points(scene, count)
    points = points[:spec.frusta] if spec.point is None else points[[spec.point]]
    geometry = PatchGeometry.of(scene, config.numbers, points)
    records = tuple(hemisphere_record(hemisphere, geometry.coordinates, point, down) for point in points)
    cell = spec.cell
    if cell is None:
        cell = choose_cell(records[::-(-len(records) // _PREDICTED)], geometry, config).cell
    request = phase_request(records, geometry, job_shelling(geometry, config, cell=cell).table, config, ratio=_RATIO,
                            clusters=spec.group, weights=hemisphere.polar_weights, hit_format=spec.hit_format,
                            sums=spec.sums)
    return PreparedJob(scene=scene, cell=cell, request=request)


@dataclass(frozen=True, kw_only=True, eq=False)
class JobRun:
    """The counts of a job.

    Parameters
    ----------
    prepared, config
        The job and the machine.
    loads, sections
        Completion records of the loads and of the sections, in the order of completion.
    read_beats, written_beats
        Beats over the memory port, those of descriptors and completion records with them.
    checked
        Results have been compared with the golden model's.
    """

    prepared: PreparedJob
    config: Config
    loads: np.ndarray
    sections: np.ndarray
    read_beats: int
    written_beats: int
    checked: bool

    @property
    def clusters(self) -> int:
        """Clusters of the machine."""
        return self.config.noc.clusters

    @property
    def rays(self) -> int:
        """Rays of all frusta."""
        return sum(map(len, self.prepared.records))

    def since_begin(self, counts: np.ndarray) -> np.ndarray:
        """Values of the engine's cycle counter as cycles since the job's first descriptor began."""
        # The first section to end need not be the first one to begin.
        known = self.loads["begin"][:1] if len(self.loads) else self.sections["begin"]
        earliest = int(((known.astype(np.int64) - int(known[0]) + _WRAP // 2) % _WRAP).min()) - _WRAP // 2
        return (np.asarray(counts, dtype=np.int64) - int(known[0]) - earliest) % _WRAP

    @property
    def cycles(self) -> int:
        """From the beginning of the first load to the last result."""
        return int(self.since_begin(np.concatenate([self.loads, self.sections])["end"]).max())

    @property
    def load_cycles(self) -> int:
        """Cycles of all loads."""
        return int((self.since_begin(self.loads["end"]) - self.since_begin(self.loads["begin"])).sum())

    @property
    def frustum_cycles(self) -> float:
        """Mean cycles of the casts of a frustum, all sections together."""
        return int(self.sections["cycles"].astype(np.int64).sum()) / len(self.prepared.records)

    @property
    def cast_cycles(self) -> float:
        """Mean cycles that a cluster casts."""
        return self.frustum_cycles * len(self.prepared.records) / self.clusters

    @property
    def cluster_cycles(self) -> dict[str, int]:
        """Where the cycles go, means of all clusters: loads, casts, no cast before the last one's end, results of the
        last cast, no more sections. Their sum is `cycles`, but for rounding.
        """
        begins, ends = self.since_begin(self.sections["begin"]), self.since_begin(self.sections["end"])
        casts, load = self.sections["cycles"].astype(np.int64), self.load_cycles
        spent = np.zeros((self.clusters, 5))
        for cluster in range(self.clusters):
            own = self.sections["cluster"] == cluster
            cast, last_cast = casts[own].sum(), (begins + casts)[own].max(initial=load)
            last_result = ends[own].max(initial=load)
            spent[cluster] = (load, cast, last_cast - load - cast, last_result - last_cast, self.cycles - last_result)
        names = ("load", "cast", "waits", "last_results", "idle")
        return dict(zip(names, spent.mean(axis=0).round().astype(int).tolist(), strict=True))

    @property
    def tests(self) -> int:
        """Tests of all sections."""
        return self._total("tested")

    @property
    def patches(self) -> dict[str, int]:
        """Patches that the clusters have read, by source."""
        return {name: int(count.sum()) for name, count in patch_sources(self.sections).items()}

    @property
    def efficiency(self) -> float:
        """Tests per cluster and cycle."""
        return self.tests / (self.clusters * self.cycles)

    @property
    def bounds(self) -> dict[str, int]:
        """Least cycles, as if all clusters had equal shares: a test a cycle, a patch in four, a beat a cycle."""
        return {"tests": -(-self.tests // self.clusters),
                "patches": -(-4 * self._total("found") // self.clusters),
                "memory": max(self.read_beats, self.written_beats)}

    @property
    def bound(self) -> str:
        """The name of the largest of `bounds`."""
        return max(self.bounds, key=self.bounds.get)

    def report(self) -> dict:
        """Counts ready for JSON."""
        frusta, bounds = len(self.prepared.records), self.bounds
        return {"scene": self.prepared.scene.name, "patches": len(self.prepared.request.geometry), "frusta": frusta,
                "rays": self.rays, "cell": self.prepared.cell, "clusters": self.clusters,
                "topology": self.config.noc.topology, "cycles": self.cycles, "cast_cycles": round(self.cast_cycles),
                "load_cycles": self.load_cycles, "cycles_per_frustum": self.cycles / frusta,
                "frustum_cycles": self.frustum_cycles, "tests": self.tests, "efficiency": self.efficiency,
                "rays_per_cycle": self.rays / self.cycles, "bound": {"name": self.bound, "cycles": bounds[self.bound]},
                "bounds": bounds, "cluster_cycles": self.cluster_cycles, "sources": self.patches,
                "read_beats": self.read_beats, "written_beats": self.written_beats, "checked": self.checked}

    def _total(self, name):
        return int(self.sections[name].astype(np.int64).sum())


@contextmanager
def job_machine(config: Config, **memory) -> Iterator[SimulatedMachine]:
    """A simulated machine that has cleared its memories after reset, as it has before a host submits its first job.

    Parameters
    ----------
    config, memory
        See `SimulatedMachine`.
    """
    with SimulatedMachine(config, **memory) as machine:
        complete(machine.port.wait(2 * config.icu.rays))
        yield machine


def run_on(machine: SimulatedMachine, prepared: PreparedJob, *, check: bool = False) -> JobRun:
    """Run a job; tables that the machine holds from the job before are not loaded.

    Parameters
    ----------
    machine
        The machine.
    prepared
        The job.
    check
        Compare its results with the golden model's.

    Raises
    ------
    EngineError, EngineTimeoutError
        See `SimulatedMachine.run`.
    SystemExit
        Results differ from the golden model's.
    """
    port = machine.port
    read, written = port.read_beats, port.written_beats
    result = machine.run([prepared.request], ring_bits=_RING_BITS)
    read, written = port.read_beats - read, port.written_beats - written
    if check:
        check_results(prepared, result, machine.config)
    is_load = (result.job.descriptors["kind"] == Kind.LOAD)[result.records["tag"]]
    return JobRun(prepared=prepared, config=machine.config, loads=result.records[is_load],
                  sections=result.records[~is_load], read_beats=read, written_beats=written, checked=check)


def check_results(prepared: PreparedJob, result: JobResult, config: Config) -> None:
    """Compare hits and sums of all frusta with the golden model's.

    Raises
    ------
    SystemExit
        One differs.
    """
    request, rays = prepared.request, len(prepared.records[0])
    whole = config.for_rays(rays)
    shelling = Shelling.of_cells(request.geometry, request.table, whole)
    for number, (record, found) in enumerate(zip(request.records, result.frusta[0], strict=True)):
        hits = shelling.cast(record)[0]
        hit, sums = hits.patch >= 0, np.zeros(len(request.geometry), dtype=np.int64)
        np.add.at(sums, hits.patch[hit], np.repeat(request.weights, record.columns)[hit])
        for name, right in (("hits", _are_hits(found.hits, hits)),
                            ("sums", found.sums is None or np.array_equal(found.sums, sums))):
            if not right:
                raise SystemExit(f"error: {prepared.scene.name}, {config.noc.clusters} clusters, frustum {number}: "
                                 f"{name} differ from the golden model's")


def _are_hits(found, expected):
    if found is None:
        return True
    return not len(found.differences(expected)) if isinstance(found, FixedHits) else np.array_equal(
        found, expected.patch)
