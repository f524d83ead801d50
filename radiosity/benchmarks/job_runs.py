"""Jobs of hemispheres from a scene's ceiling on the simulated machine, and what they took."""

from dataclasses import dataclass

import numpy as np

from golden.cast.shelling import Shelling
from golden.config import Config
from golden.frustum import FrustumRecord, Hemisphere, hemisphere_record
from golden.jobs.completion import COMPLETION
from golden.jobs.descriptor import Kind
from golden.jobs.job import Job, PhaseRequest, plan_job
from golden.jobs.result_formats import HitFormat
from golden.jobs.run_job import run_job
from golden.scene.open import open_scene
from golden.scene.patch_geometry import PatchGeometry
from golden.scene.scene import Scene
from golden.schedule.ceiling_points import ceiling_points
from golden.schedule.cell_choice import choose_cell
from golden.schedule.phase import machine_schedule
from hw.host import Host
from hw.registers.error_code import ErrorCode
from hw.simulator.simulated_port import SimulatedPort, complete

__all__ = ["JobMachine", "JobRun", "JobSpec", "PreparedJob", "prepare_job"]

# The engine's cycle counter wraps.
_WRAP = 1 << 32
# Frusta from which the cell size is chosen; rays of a frustum for each one that a schedule casts.
_PREDICTED, _RATIO = 4, 16


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
        See `golden.jobs.job.PhaseRequest`; ``group`` is its ``clusters``.
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
    scene, patches, records, cell
        What is cast into what, how many patches it has for the machine, and the size of its cells.
    job
        Descriptors and tables.
    """

    scene: Scene
    patches: int
    records: tuple[FrustumRecord, ...]
    cell: float
    job: Job


def prepare_job(spec: JobSpec, config: Config) -> PreparedJob:
    """The job on a machine of a configuration.

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
    table = Shelling(geometry, config, cell=cell).table
    # Patches that do not fit a cluster are divided among all; lists of subshells are of a schedule.
    plan = None
    if config.ctu.subshells or (len(geometry) > config.memsys.own_patches and config.noc.nodes > 1):
        plan = machine_schedule(records[0], geometry, table, config, ratio=_RATIO)
    request = PhaseRequest(geometry=geometry, table=table, records=records, weights=hemisphere.polar_weights,
                           hit_format=spec.hit_format, sums=spec.sums, clusters=spec.group, plan=plan)
    # All descriptors fit the ring at once.
    sections = 2 * len(records) * max(spec.group, -(-len(records[0]) // config.icu.rays))
    job = plan_job([request], config, ring_bits=sections.bit_length())
    return PreparedJob(scene=scene, patches=len(geometry), records=records, cell=cell, job=job)


@dataclass(frozen=True, kw_only=True, eq=False)
class JobRun:
    """What a job took.

    Parameters
    ----------
    prepared, config
        The job and the machine.
    loads, sections
        Completion records of the loads and of the sections, in the order of their numbers.
    read_beats, written_beats
        Beats over the memory port, those of descriptors and completion records with them.
    checked
        Results have been compared with golden's.
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
        return self.config.noc.nodes

    @property
    def rays(self) -> int:
        """Rays of all frusta."""
        return sum(map(len, self.prepared.records))

    def since_begin(self, counts: np.ndarray) -> np.ndarray:
        """Values of the engine's cycle counter as cycles since the job's first descriptor began."""
        begin = np.concatenate([self.loads, self.sections])[0]["begin"]
        return (np.asarray(counts, dtype=np.int64) - int(begin)) % _WRAP

    @property
    def cycles(self) -> int:
        """From the begin of the first load to the last result."""
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
    def tests(self) -> int:
        """Tests of all sections."""
        return self._total("tested")

    @property
    def patches(self) -> dict[str, int]:
        """Patches that the clusters have read, by source."""
        return {name: self._total(name) for name in ("own", "remote", "hits", "misses")}

    @property
    def efficiency(self) -> float:
        """Tests per cluster and cycle."""
        return self.tests / (self.clusters * self.cycles)

    @property
    def bounds(self) -> dict[str, int]:
        """Least cycles, as if all clusters had equal shares: a test a cycle, a patch in four, a beat a cycle."""
        return {"tests": -(-self.tests // self.clusters),
                "patches": -(-4 * sum(self.patches.values()) // self.clusters),
                "memory": max(self.read_beats, self.written_beats)}

    @property
    def bound(self) -> str:
        """The name of the largest of `bounds`."""
        return max(self.bounds, key=self.bounds.get)

    def report(self) -> dict:
        """Counts ready for JSON."""
        frusta, bounds = len(self.prepared.records), self.bounds
        return {"scene": self.prepared.scene.name, "patches": self.prepared.patches, "frusta": frusta,
                "rays": self.rays, "cell": self.prepared.cell, "clusters": self.clusters,
                "topology": self.config.noc.topology, "cycles": self.cycles, "cast_cycles": round(self.cast_cycles),
                "load_cycles": self.load_cycles, "cycles_per_frustum": self.cycles / frusta,
                "frustum_cycles": self.frustum_cycles, "tests": self.tests, "efficiency": self.efficiency,
                "rays_per_cycle": self.rays / self.cycles, "bound": {"name": self.bound, "cycles": bounds[self.bound]},
                "bounds": bounds, "sources": self.patches, "read_beats": self.read_beats,
                "written_beats": self.written_beats, "checked": self.checked}

    def _total(self, name):
        return int(self.sections[name].astype(np.int64).sum())


class JobMachine:
    """The simulated machine with a host that gives it jobs.

    Parameters
    ----------
    config
        The configuration.
    memory
        Parameters of `SimulatedPort`: latency, spread, shuffles, seed, library, progress.
    """

    def __init__(self, config: Config, **memory):
        self.config, self.port = config, SimulatedPort(config, size=0, **memory)
        self.host = Host(self.port, config)
        # Completion records of the loads of the present job.
        self._loads = np.zeros(0, dtype=COMPLETION.dtype)
        complete(self.host.identify())
        # As after any reset: the host is slower than the machine, which clears its memories meanwhile.
        complete(self.port.wait(2 * config.icu.rays))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.port.close()

    def run(self, prepared: PreparedJob, *, check: bool = False) -> JobRun:
        """Have a job done.

        Parameters
        ----------
        prepared
            The job.
        check
            Compare its results with golden's.

        Raises
        ------
        EngineError, EngineTimeoutError
            See `Host.run`.
        SystemExit
            A descriptor has failed, or results are not golden's.
        """
        if prepared.job.end > self.port.size:
            self.port.resize(prepared.job.end)
        complete(self.host.begin(prepared.job))
        self._loads = self._loads[:0]
        return self._run(prepared, prepared.job.descriptors, check=check)

    def again(self, prepared: PreparedJob, *, check: bool = False) -> JobRun:
        """Cast all frusta of the last job again, without its loads; parameters and errors as of `run`."""
        return self._run(prepared, prepared.job.descriptors[prepared.job.descriptors["kind"] == Kind.FRUSTUM],
                         check=check)

    def _run(self, prepared, descriptors, *, check):
        job, port = prepared.job, self.port
        read, written = port.read_beats, port.written_beats
        records = complete(self.host.run(job, descriptors))
        read, written = port.read_beats - read, port.written_beats - written
        for record in records[records["error"] != 0]:
            raise SystemExit(f"error: {prepared.scene.name}, {self.config.noc.nodes} clusters: descriptor "
                             f"{record['tag']} fails: {ErrorCode(record['error']).name}")
        is_load = (job.descriptors["kind"] == Kind.LOAD)[records["tag"]]
        loads, sections = records[is_load], records[~is_load]
        self._loads = loads if len(loads) else self._loads
        if check:
            self._check(prepared, np.concatenate([self._loads, sections]))
        return JobRun(prepared=prepared, config=self.config, loads=loads, sections=sections, read_beats=read,
                      written_beats=written, checked=check)

    def _check(self, prepared, records):
        found = run_job(prepared.job).differences(
            records, lambda address, size: complete(self.port.read_memory(address, size)),
            {code.value: code.name for code in ErrorCode})
        if found:
            raise SystemExit(f"error: {prepared.scene.name}, {self.config.noc.nodes} clusters: results are not "
                             f"golden's: {'; '.join(found[:4])}")
