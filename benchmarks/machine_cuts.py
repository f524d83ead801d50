"""Frusta that clusters share, simulated beside those of the hardware that docs/figures/cut-cycles.csv has.

Each cluster casts a section of the frustum and holds a share of the patches. The sections and the shares follow from a
sparse casting from another point of the ceiling; or the first cluster holds all patches. Where clusters have patch
stores, sections are cut at tiles, as a job cuts them.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.ceiling import HEMISPHERE, RATIO, Ceiling
from benchmarks.engine import CASTS, LATENCY, POINT
from benchmarks.recorded import read_rows
from golden.cast.hemisphere import Hemisphere
from golden.engine.config import PRESETS, Config
from golden.engine.jobs.order import longest_first_at_the_end
from golden.engine.jobs.tile_sections import tile_sections
from golden.engine.memsys.patches.patch_store import PatchStore
from golden.engine.schedule.phase import machine_schedule
from radiosity.flow.simulator.simulation_config import simulation_config
from radiosity.machines.engine.cluster_latencies import cluster_timing
from radiosity.machines.engine.job_latencies import bus_timing, joint_options, joint_timing, store_timing
from radiosity.machines.engine.joint_cast import joint_cast
from radiosity.machines.engine.section_trace import CastTimes, SectionTrace
from radiosity.machines.engine.simulated_cast import cast_section

__all__ = ["CutRow", "PreparedCut", "cut_config", "prepare_cut", "recorded_cuts", "simulate_cut", "simulated_cuts",
           "thesis_config"]

_RAYS = HEMISPHERE.azimuths, HEMISPHERE.polars
# Of the hardware that was recorded.
_PARAMETERS = {"memsys.own_patches": 1024, "memsys.filter_generation_bits": 4}


@dataclass(frozen=True, kw_only=True)
class CutRow:
    """A cast of the hardware: preset ``paper`` with 1024 patches in each cluster; with patch stores the third one.

    Parameters
    ----------
    scene, topology, clusters, cell
        Scene, network, clusters, and size of the cells.
    sets
        ``scheduled`` by the sparse casting, or ``first``: the first cluster holds all patches.
    store
        Patches that the patch store of each cluster keeps; 0: there is none.
    cycles
        From the begin of the first section's cast to the end of the last one's.
    """

    scene: str
    topology: str
    clusters: int
    cell: float
    sets: str
    store: int
    cycles: int


@dataclass(frozen=True, kw_only=True, eq=False)
class PreparedCut:
    """A frustum that clusters share.

    Parameters
    ----------
    traces
        The section of each cluster, cast by a cluster that has all patches.
    home
        N int64: the cluster that holds each patch, -1 if none does.
    tests
        C int64: tests of each cluster.
    """

    traces: tuple[SectionTrace, ...]
    home: np.ndarray
    tests: np.ndarray

    @property
    def edrc(self) -> np.ndarray:
        """C float64: tests of each cluster for each patch that it finds."""
        return self.tests / np.maximum(1, [len(trace.patch) for trace in self.traces])


def recorded_cuts() -> tuple[CutRow, ...]:
    """The casts of the hardware."""
    return read_rows("cut-cycles", CutRow)


def cut_config(clusters: int, topology: str = "mesh", store: int = 0) -> Config:
    """The configuration of that hardware, or one with another network; ``store`` are patches of each patch store."""
    return simulation_config(PRESETS["paper"].replace(_PARAMETERS | {"memsys.store_patches": store}),
                             clusters=clusters, topology=topology, rays=_RAYS[0] * _RAYS[1])


def thesis_config(clusters: int, topology: str = "torus", rays: tuple[int, int] = _RAYS) -> Config:
    """The configuration of the thesis' machine: subshell lists, resident sets of what the sparse casting has found."""
    return simulation_config(PRESETS["thesis"], clusters=clusters, topology=topology,
                             rays=1 << (rays[0] * rays[1] - 1).bit_length())


def prepare_cut(scene: str, config: Config, *, cell: float, rays: tuple[int, int] = _RAYS, point: int = POINT,
                tiles: bool = False) -> PreparedCut:
    """The frustum of a scene, cut for the clusters of a configuration.

    Parameters
    ----------
    scene, config, cell
        The scene, the configuration, and the size of the cells.
    rays, point
        Azimuths and polar angles of the hemisphere, and the point of the ceiling that it is cast from.
    tiles
        Cut the sections of a machine without subshell lists at tiles of the settle map, in the order of a job's queue.
    """
    ceiling = Ceiling(scene, config, cell=cell, hemisphere=Hemisphere(*rays), by_code=True)
    record, shelling, timing = ceiling.record(point), ceiling.shelling, cluster_timing(config)
    plan = machine_schedule(ceiling.record(), ceiling.geometry, shelling.table, config, ratio=RATIO)
    sections = _queued_sections(record, plan, config) if tiles else plan.partition.sections
    subshells = plan.subshells if config.ctu.subshells else [None] * len(sections)
    casts = [cast_section(shelling, record, config, timing, section=section, subshells=listed)
             for section, listed in zip(sections, subshells, strict=True)]
    return PreparedCut(traces=tuple(cast.trace for cast in casts), tests=np.array([cast.tests for cast in casts]),
                       home=plan.sets.residence(len(ceiling.geometry))[0])


def _queued_sections(record, plan, config):
    """Sections as a job has them, those with most work first."""
    workload = plan.found.frusta.share(plan.found.tests)
    sections = tile_sections(record.columns, record.rows, config, clusters=config.noc.clusters, workload=workload)
    work = np.array([workload[one.first_row:one.end_row, one.first_column:one.end_column].sum() for one in sections])
    return [sections[one] for one in longest_first_at_the_end(work, clusters=config.noc.clusters)]


def simulate_cut(prepared: PreparedCut, config: Config, *, local: int | None = None,
                 kept: Sequence[int] = (), stores: Sequence[PatchStore] = ()) -> tuple[CastTimes, ...]:
    """The times of all clusters.

    Parameters
    ----------
    prepared, config
        The frustum, and the configuration.
    local
        Cycles in which a memory has a patch read. Default: one for each vertex.
    kept
        Patches that the cache has served before, in their order. Default: it is empty.
    stores
        The patch store of each cluster, which changes. Default: clusters have none.
    """
    timing, joint = cluster_timing(config), joint_timing(config)
    if local is not None:
        timing, joint = replace(timing, vertices=local), replace(joint, port=local)
    return joint_cast(
        prepared.traces, prepared.home, timing, joint, bus=bus_timing(config, latency=LATENCY), kept=kept,
        store=store_timing(config) if stores else None, stores=stores, **joint_options(config)).times


def _third_times(prepared, config):
    """The times of the third cast, with what the stores have kept of the casts before.

    The next section goes to the cluster that has waited longest.
    """
    stores = [PatchStore(config.memsys.store_patches) for _ in prepared.traces]
    waiting = range(len(stores))
    for _ in range(CASTS):
        traces = tuple(prepared.traces[section] for section in np.argsort(waiting))
        times = simulate_cut(replace(prepared, traces=traces), config, stores=stores)
        waiting = np.argsort([one.cycles for one in times], kind="stable")
    return times


def simulated_cuts(rows: Iterable[CutRow]) -> Iterator[tuple[CutRow, int]]:
    """Each row, with the cycles of the slowest simulated cluster."""
    for row in rows:
        config = cut_config(row.clusters, row.topology, row.store)
        prepared = prepare_cut(row.scene, config, cell=row.cell, tiles=row.store > 0)
        if row.sets == "first":
            prepared = replace(prepared, home=np.zeros_like(prepared.home))
        times = _third_times(prepared, config) if row.store else simulate_cut(prepared, config)
        yield row, max(each.cycles for each in times)
