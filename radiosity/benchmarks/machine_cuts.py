"""Frusta that clusters share, simulated beside those of the hardware that docs/figures/cut-cycles.csv has.

Each cluster casts a section of the frustum and holds a share of the patches. The sections and the shares follow from a
sparse casting from another point of the ceiling; or the first cluster holds all patches.
"""

import csv
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from golden.cast.shelling import Shelling
from golden.config import PRESETS, Config
from golden.frustum import Hemisphere, hemisphere_record
from golden.machines.cast_store import CastStore
from golden.machines.joint_cast import joint_cast
from golden.machines.section_trace import CastTimes, SectionTrace
from golden.noc.routing import route
from golden.scene.open import open_scene
from golden.scene.patch_geometry import PatchGeometry
from golden.schedule.ceiling_points import ceiling_points
from golden.schedule.phase import machine_schedule
from hw.history import ROOT
from hw.simulator.simulation_config import simulation_config
from radiosity.benchmarks.engine import POINT
from radiosity.cluster_timing import cluster_timing
from radiosity.job_timing import bus_timing, joint_timing

__all__ = ["CutRow", "PreparedCut", "cut_config", "prepare_cut", "recorded_cuts", "simulate_cut", "simulated_cuts",
           "thesis_config"]

_RECORDED = ROOT / "docs" / "figures" / "cut-cycles.csv"
# Rays, the point of the ceiling that the sparse casting is from, and rays for each of its own.
_RAYS, _REFERENCE, _RATIO = (256, 64), 0, 64
# Cycles of main memory, for patches that no cluster holds.
_LATENCY = 10
# Of the hardware that was recorded: it had no patch store.
_PARAMETERS = {"memsys.own_patches": 1024, "memsys.store_patches": 0, "memsys.filter_generation_bits": 4}


@dataclass(frozen=True, kw_only=True)
class CutRow:
    """A warm cast of the hardware: preset ``paper`` with 1024 patches in each cluster.

    Parameters
    ----------
    scene, topology, clusters, cell
        Scene, network, clusters, and size of the cells.
    sets
        ``scheduled`` by the sparse casting, or ``first``: the first cluster holds all patches.
    cycles
        From the begin of the first section's cast to the end of the last one's.
    """

    scene: str
    topology: str
    clusters: int
    cell: float
    sets: str
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
    with _RECORDED.open(newline="") as file:
        return tuple(CutRow(scene=row["scene"], topology=row["topology"], clusters=int(row["clusters"]),
                            cell=float(row["cell"]), sets=row["sets"], cycles=int(row["cycles"]))
                     for row in csv.DictReader(file))


def cut_config(clusters: int, topology: str = "mesh") -> Config:
    """The configuration of that hardware, or one with another network."""
    return simulation_config(PRESETS["paper"].replace(_PARAMETERS), clusters=clusters, topology=topology,
                             rays=_RAYS[0] * _RAYS[1])


def thesis_config(clusters: int, topology: str = "torus", rays: tuple[int, int] = _RAYS) -> Config:
    """The configuration of the thesis' machine: subshell lists, resident sets of what the sparse casting has found."""
    return simulation_config(PRESETS["thesis"], clusters=clusters, topology=topology,
                             rays=1 << (rays[0] * rays[1] - 1).bit_length())


def prepare_cut(scene: str, config: Config, *, cell: float, rays: tuple[int, int] = _RAYS, point: int = POINT,
                folder: Path | None = None) -> PreparedCut:
    """The frustum of a scene, cut for the clusters of a configuration.

    Parameters
    ----------
    scene, config, cell
        The scene, the configuration, and the size of the cells.
    rays, point
        Azimuths and polar angles of the hemisphere, and the point of the ceiling that it is cast from.
    folder
        Casts are kept there. Default: they are not kept.
    """
    opened, hemisphere = open_scene(scene), Hemisphere(*rays)
    points, down = ceiling_points(opened)
    geometry = PatchGeometry.of(opened, config.numbers, points)
    reference, record = (hemisphere_record(hemisphere, geometry.coordinates, points[origin], down)
                         for origin in (_REFERENCE, point))
    shelling = Shelling(geometry, config, cell=cell, by_code=True)
    plan = machine_schedule(reference, geometry, shelling.table, config, ratio=_RATIO)
    store = CastStore(shelling, config, cluster_timing(config), folder=folder)
    subshells = plan.subshells if config.ctu.subshells else [None] * len(plan.partition.sections)
    casts = [store.cast(record, section, listed) for section, listed in zip(
        plan.partition.sections, subshells, strict=True)]
    return PreparedCut(traces=tuple(cast.trace for cast in casts), home=plan.sets.residence(len(geometry))[0],
                       tests=np.array([cast.tests for cast in casts]))


def simulate_cut(prepared: PreparedCut, config: Config, *, local: int | None = None,
                 kept: Sequence[int] = ()) -> list[CastTimes]:
    """The times of all clusters.

    Parameters
    ----------
    prepared, config
        The frustum, and the configuration.
    local
        Cycles in which a memory has a patch read. Default: one for each vertex.
    kept
        Patches that the cache has served before, in their order. Default: it is empty.
    """
    noc, timing, joint = config.noc, cluster_timing(config), joint_timing(config)
    if local is not None:
        timing, joint = replace(timing, vertices=local), replace(joint, port=local)
    return joint_cast(
        prepared.traces, prepared.home, timing, joint,
        routing=route(noc.network(), noc.virtual_channels), buffer_flits=noc.buffer_flits, arbitration=noc.arbitration,
        router_cycles=noc.router_cycles, slots=config.icu.slots, run_ahead=config.ctu.run_ahead,
        bus=bus_timing(config, latency=_LATENCY), memsys=config.memsys, kept=kept)


def simulated_cuts(rows: Iterable[CutRow], *, folder: Path | None = None) -> Iterator[tuple[CutRow, int]]:
    """Each row, with the cycles of the slowest simulated cluster; casts are kept in a folder, if there is one."""
    for row in rows:
        config = cut_config(row.clusters, row.topology)
        prepared = prepare_cut(row.scene, config, cell=row.cell, folder=folder)
        if row.sets == "first":
            prepared = replace(prepared, home=np.zeros_like(prepared.home))
        yield row, max(each.cycles for each in simulate_cut(prepared, config))
