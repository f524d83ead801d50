"""Frusta in scenes larger than a cluster's memory, simulated beside those of docs/figures/memory-cycles.csv.

One cluster holds the first 1024 patches of a scene, of preset ``thesis`` those that a sparse casting has found.
The others come from main memory, over the bus and through the cache. Frusta are hemispheres of 256 x 64 rays and
screens of 128 x 128. Clusters with a patch store have the lists of a job, of which the long ones are scattered.
"""

import csv
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from benchmarks.engine import POINT
from golden.cast.default_camera import default_camera
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.cast.shelling import Shelling
from golden.engine.config import PRESETS
from golden.engine.ctu.sector import Sector
from golden.engine.frustum import hemisphere_record
from golden.engine.frustum.record import screen_record
from golden.engine.noc.routing import route
from golden.engine.noc.topology import Topology
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.ceiling_points import ceiling_points
from golden.engine.schedule.job_shelling import job_shelling
from golden.engine.schedule.phase import machine_schedule
from golden.scene.open import open_scene
from radiosity.flow.simulator.simulation_config import simulation_config
from radiosity.flow.synthesis.history import ROOT
from radiosity.machines.engine.cast_store import CastStore
from radiosity.machines.engine.cluster_latencies import cluster_timing
from radiosity.machines.engine.found_ahead import found_ahead
from radiosity.machines.engine.job_latencies import bus_timing, joint_timing, store_timing
from radiosity.machines.engine.joint_cast import joint_cast
from radiosity.machines.engine.store_path import store_after

__all__ = ["MemoryRow", "recorded_memory", "simulated_memory"]

_RECORDED = ROOT / "docs" / "figures" / "memory-cycles.csv"
# Of a sparse casting: rays for each of its own.
_RAYS, _SCREEN, _RESIDENT, _RATIO = (256, 64), (128, 128), 1024, 16
# Casts of the same frustum before the warm one.
_BEFORE = 2
# The network of one cluster carries nothing.
_TOPOLOGY = Topology("mesh", 2, 1)


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
    with _RECORDED.open(newline="") as file:
        return tuple(MemoryRow(preset=row["preset"], scene=row["scene"], frustum=row["frustum"],
                               cell=float(row["cell"]), latency=int(row["latency"]), store=int(row["store"]),
                               cycles=int(row["cycles"]))
                     for row in csv.DictReader(file))


def simulated_memory(rows: tuple[MemoryRow, ...]) -> Iterator[tuple[MemoryRow, int]]:
    """Each row, with its simulated cycles."""
    for row in rows:
        config = simulation_config(PRESETS[row.preset].replace({"memsys.store_patches": row.store}), clusters=1,
                                   topology="mesh", rays=_RAYS[0] * _RAYS[1])
        noc, timing, joint = config.noc, cluster_timing(config), joint_timing(config)
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
        fetched, stores = np.tile(trace.patch[home[trace.patch] < 0], _BEFORE), {}
        if store:
            # The cache has served what the store had not.
            kept, fetched = store_after(row.store, fetched)
            stores = {"store": store, "stores": [kept]}
        cast = joint_cast(
            [trace], home, timing, joint, routing=route(_TOPOLOGY, noc.virtual_channels),
            buffer_flits=noc.buffer_flits, arbitration=noc.arbitration, router_cycles=noc.router_cycles,
            slots=config.icu.slots, run_ahead=config.ctu.run_ahead, bus=bus, memsys=config.memsys, kept=fetched,
            **stores)
        yield row, cast.times[0].cycles


def _frustum(row, config):
    """Patches and frustum of a row: from a point of the ceiling, or from the scene's camera."""
    scene = open_scene(row.scene)
    if row.frustum == "screen":
        camera = default_camera(scene)
        geometry = PatchGeometry.of(scene, config.numbers, [camera.eye])
        return geometry, screen_record(Screen(camera=camera, width=_SCREEN[0], height=_SCREEN[1]), geometry.coordinates)
    points, down = ceiling_points(scene)
    geometry = PatchGeometry.of(scene, config.numbers, points[[POINT]])
    return geometry, hemisphere_record(Hemisphere(*_RAYS), geometry.coordinates, points[POINT], down)
