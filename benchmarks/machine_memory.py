"""Frusta in scenes larger than a cluster's memory, simulated beside those of docs/figures/memory-cycles.csv.

One cluster holds the first 1024 patches of a scene, of preset ``thesis`` those that a sparse casting has found.
The others come from main memory, over the bus and through the cache. Frusta are hemispheres of 256 x 64 rays and
screens of 128 x 128. Clusters with a patch store have the lists of a job, of which the long ones are scattered.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.ceiling import HEMISPHERE, Ceiling
from benchmarks.engine import CASTS, POINT
from benchmarks.recorded import read_rows
from golden.cast.default_camera import default_camera
from golden.cast.screen import Screen
from golden.engine.cast.shelling import Shelling
from golden.engine.config import PRESETS
from golden.engine.ctu.sector import Sector
from golden.engine.frustum.record import screen_record
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.job_shelling import job_shelling
from golden.engine.schedule.phase import machine_schedule
from golden.scene.open import open_scene
from radiosity.flow.simulator.simulation_config import simulation_config
from radiosity.machines.engine.cast_store import CastStore
from radiosity.machines.engine.cluster_latencies import cluster_timing
from radiosity.machines.engine.found_ahead import found_ahead
from radiosity.machines.engine.job_latencies import bus_timing, joint_options, joint_timing, store_timing
from radiosity.machines.engine.joint_cast import joint_cast
from radiosity.machines.engine.store_path import store_after

__all__ = ["MemoryRow", "recorded_memory", "simulated_memory"]

# Rays along a screen's sides, patches of the cluster, and rays of a sparse casting for each of its own.
_SCREEN, _RESIDENT, _RATIO = 128, 1024, 16


@dataclass(frozen=True, kw_only=True)
class MemoryRow:
    """A warm cast of the hardware: one cluster.

    Parameters
    ----------
    preset
        ``paper`` or ``thesis``.
    scene, frustum, cell
        Scene, ``hemisphere`` or ``screen``, and size of the cells.
    latency
        Cycles of main memory.
    store
        Patches that the patch store keeps; 0: there is none.
    cycles
        Of the cast.
    """

    preset: str
    scene: str
    frustum: str
    cell: float
    latency: int
    store: int
    cycles: int


def recorded_memory() -> tuple[MemoryRow, ...]:
    """The casts of the hardware."""
    return read_rows("memory-cycles", MemoryRow)


def simulated_memory(rows: tuple[MemoryRow, ...]) -> Iterator[tuple[MemoryRow, int]]:
    """Each row, with its simulated cycles."""
    for row in rows:
        config = simulation_config(PRESETS[row.preset].replace({"memsys.store_patches": row.store}), clusters=1,
                                   topology="mesh", rays=len(HEMISPHERE))
        timing, joint = cluster_timing(config), joint_timing(config)
        bus, store = bus_timing(config, latency=row.latency), store_timing(config) if row.store else None
        geometry, record = _frustum(row, config)
        shelling = Shelling(geometry, config, cell=row.cell, by_code=True)
        if row.store:
            table = job_shelling(geometry, config, cell=row.cell).table
            shelling = Shelling.of_cells(geometry, table, config, by_code=True)
        home, subshells = np.where(np.arange(len(geometry)) < _RESIDENT, 0, -1), None
        if config.ctu.subshells:
            plan = machine_schedule(record, geometry, shelling.table, config, ratio=_RATIO)
            home, (subshells,) = plan.sets.residence(len(geometry))[0], plan.subshells
        trace = CastStore(shelling, config, timing).cast(
            record, Sector.whole(record), subshells, others=home < 0,
            ahead=found_ahead(timing, joint, bus, store)).trace
        fetched, stores = np.tile(trace.patch[home[trace.patch] < 0], CASTS - 1), {}
        if store:
            # The cache has served what the store had not.
            kept, fetched = store_after(row.store, fetched)
            stores = {"store": store, "stores": [kept]}
        cast = joint_cast([trace], home, timing, joint, bus=bus, kept=fetched, **stores, **joint_options(config))
        yield row, cast.times[0].cycles


def _frustum(row, config):
    """Patches and frustum of a row: from a point of the ceiling, or from the scene's camera."""
    if row.frustum == "screen":
        scene = open_scene(row.scene)
        camera = default_camera(scene)
        geometry = PatchGeometry.of(scene, config.numbers, [camera.eye])
        return geometry, screen_record(Screen(camera=camera, width=_SCREEN, height=_SCREEN), geometry.coordinates)
    ceiling = Ceiling(row.scene, config, point=POINT)
    return ceiling.geometry, ceiling.record()
