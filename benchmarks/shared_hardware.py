"""Cycles of machines that share a scene, of the hardware: docs/figures/istructure-cycles.csv."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache

import numpy as np

from benchmarks.recorded import read_rows
from benchmarks.shared_scene import LATENCY, Access, Placement, SharedScene, shared_config
from golden.engine.config import Config
from radiosity.machines.engine.job_runs import job_machine

__all__ = ["SharedRow", "cast_rows", "recorded_rows", "simulated_rows"]


@dataclass(frozen=True, kw_only=True)
class SharedRow:
    """A cast of the hardware: preset ``paper``, a frustum for each cluster behind another one.

    Parameters
    ----------
    scene, clusters
        Scene, and clusters.
    sets, share
        ``dealt`` or ``discovery``, and the share of the patches that a cluster has memory for.
    store, requests
        Patches that a store keeps, 0: there is none; and requests that it has in flight.
    cycles
        Mean of the clusters.
    """

    scene: str
    clusters: int
    sets: str
    share: float
    store: int
    requests: int
    cycles: int

    def home(self, scene: SharedScene) -> np.ndarray:
        """Where patches are."""
        return scene.home(self.clusters, Placement(self.sets), self.share)

    def config(self) -> Config:
        """The machine's."""
        return shared_config(self.clusters).replace(
            {"memsys.store_patches": self.store, "memsys.store_requests": self.requests})


def recorded_rows() -> tuple[SharedRow, ...]:
    """The casts of the hardware."""
    return read_rows("istructure-cycles", SharedRow)


def simulated_rows(rows: Iterable[SharedRow]) -> Iterator[tuple[SharedRow, float]]:
    """Each row with its simulated cycles."""
    made = cache(SharedScene)
    for row in rows:
        scene = made(row.scene)
        cast = scene.cast(row.clusters, row.home(scene), Access.DEFERRAL if row.store else Access.NETWORK,
                          frames=row.store, requests=row.requests)
        yield row, float(np.mean([one.cycles for one in cast.times]))


def cast_rows(rows: Iterable[SharedRow]) -> Iterator[tuple[SharedRow, float]]:
    """Each row with the cycles of the hardware; rows of one machine after the other."""
    made, machines = cache(SharedScene), {}
    for row in rows:
        machines.setdefault((row.clusters, row.store, row.requests), []).append(row)
    for each in machines.values():
        with job_machine(each[0].config(), latency=LATENCY) as machine:
            for row in each:
                scene = made(row.scene)
                home = row.home(scene)
                for step in 0, 1:
                    result = machine.run([scene.request(row.clusters, home, step)])
                yield row, float(result.records["cycles"].mean())
