"""A scene that the clusters of a machine share: the same frusta, with any resident sets and any path to other patches.

Each cluster casts a hemisphere of its own, from one point of the ceiling after another.
"""

from dataclasses import dataclass, replace
from enum import Enum
from functools import cache

import numpy as np

from benchmarks.ceiling import Ceiling
from benchmarks.thesis_memory import in_turn
from golden.cast.hemisphere import Hemisphere
from golden.engine.config import PRESETS, Config
from golden.engine.ctu.sector import Sector
from golden.engine.jobs.job import PhaseRequest
from golden.engine.schedule.cell_choice import choose_cell
from golden.engine.schedule.job_shelling import job_shelling
from golden.engine.schedule.phase import schedule
from golden.engine.schedule.resident_sets import ResidentSets, spread_sets
from radiosity.flow.simulator.simulation_config import simulation_config
from radiosity.machines.engine.cast_store import CastStore
from radiosity.machines.engine.cluster_cast import KEPT, NO_CLUSTER
from radiosity.machines.engine.cluster_latencies import cluster_timing
from radiosity.machines.engine.found_ahead import found_ahead
from radiosity.machines.engine.job_latencies import bus_timing, joint_options, joint_timing, store_timing
from radiosity.machines.engine.joint_cast import JointCast, joint_cast
from radiosity.machines.engine.store_path import store_after

__all__ = ["LATENCY", "Access", "Outcome", "Placement", "SharedScene", "shared_config"]

# Cycles of main memory.
LATENCY = 50
_RAYS = (256, 64)
# The ceiling's points, of which the sparse casting is from the first one; rays for each of its own; and frusta that the
# cell size is chosen from.
_POINTS, _RATIO, _PREDICTED = 16, 16, 4
# A patch store keeps this share of a scene's patches, rounded to a power of two.
_STORED = 8


class Access(Enum):
    """The parts between a cluster and the patches that it does not hold.

    A patch store whose presence bits defer requests, or block those behind them, or that has one request in flight;
    the network and main memory alone; and main memory alone.
    """

    DEFERRAL = "deferral"
    BLOCKING = "blocking"
    SINGLE = "one request"
    NETWORK = "no store"
    MEMORY = "main memory"

    @property
    def has_store(self) -> bool:
        """Whether there is a patch store."""
        return self in (Access.DEFERRAL, Access.BLOCKING, Access.SINGLE)


class Placement(Enum):
    """How patches are distributed to resident sets: in turn, by a sparse casting, or each to every cluster."""

    DEALT = "dealt"
    DISCOVERY = "discovery"
    EVERYWHERE = "everywhere"


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """Means of a cluster and its frustum.

    Parameters
    ----------
    cycles
        From the begin of its cast to the end.
    own, kept, remote, hits, misses
        Patches from its own memory, from its patch store without a fetch, from other clusters, from the cache, and
        from main memory.
    deferred
        Requests that waited in its patch store.
    flits
        That the network's routers have sent for its requests.
    """

    cycles: float
    own: float
    kept: float
    remote: float
    hits: float
    misses: float
    deferred: float
    flits: float


def shared_config(clusters: int, rays: tuple[int, int] = _RAYS) -> Config:
    """The machine: preset ``paper`` with so many clusters in a mesh, and cells as for 4096 patches in each of them."""
    return simulation_config(PRESETS["paper"].replace({"memsys.own_patches": 4096}), clusters=clusters, topology="mesh",
                             rays=rays[0] * rays[1])


class SharedScene:
    """Simulates machines of preset ``paper`` that share a scene.

    Parameters
    ----------
    name
        The scene's name.
    rays
        Azimuths and polar angles of each hemisphere.
    cell
        Size of the cells. Default: chosen for the frusta.

    Members
    -------
    cell, patches
        Size of the cells, and number of patches.
    frames
        Patches that a patch store keeps: about an eighth.
    """

    def __init__(self, name: str, *, rays: tuple[int, int] = _RAYS, cell: float | None = None):
        config = shared_config(1, rays)
        ceiling = Ceiling(name, config, hemisphere=Hemisphere(*rays))
        geometry, self._records = ceiling.geometry, [ceiling.record(point) for point in range(_POINTS)]
        self.cell = cell or choose_cell(self._records[::_POINTS // _PREDICTED], geometry, config).cell
        self._shelling = job_shelling(geometry, config, cell=self.cell, by_code=True)
        self.patches, self.frames = len(geometry), 1 << max(1, round(np.log2(len(geometry) / _STORED)))
        self._rays, self._store = rays, cache(self._casts)

    def _casts(self, pipelines):
        """Casts of clusters with so many traversal pipelines."""
        config = shared_config(1, self._rays).replace({"ctu.pipelines": pipelines})
        return CastStore(self._shelling, config, cluster_timing(config))

    def _trace(self, clusters, point, others, ahead):
        """The cast of a frustum by one cluster alone, which does not hold some patches."""
        record = self._records[point % _POINTS]
        return self._store(shared_config(clusters, self._rays).ctu.traversal_pipelines(clusters)).cast(
            record, Sector.whole(record), others=others, ahead=ahead).trace

    def home(self, clusters: int, placement: Placement, share: float) -> np.ndarray:
        """The cluster that holds each patch as each cluster knows it, -1 if none does.

        Parameters
        ----------
        clusters
            Clusters, a power of two.
        placement, share
            Where patches are, and the share of them that a cluster has memory for.
        """
        if placement is Placement.EVERYWHERE:
            return np.tile(np.arange(clusters)[:, None], self.patches)
        capacity = int(np.ceil(share * self.patches))
        if placement is Placement.DEALT:
            sets = spread_sets(self.patches, clusters=clusters, capacity=capacity)
        else:
            sets = schedule(self._records[0], self._shelling.geometry, self._shelling.table,
                            shared_config(clusters, self._rays), clusters=clusters, ratio=_RATIO, capacity=capacity,
                            fill=True).sets
        return np.tile(sets.residence(self.patches)[0], (clusters, 1))

    def request(self, clusters: int, home: np.ndarray, step: int) -> PhaseRequest:
        """The frusta of clusters of the hardware, which hold what they know: a step before those compared, or these."""
        records = [self._records[(number + step) % _POINTS] for number in range(clusters)]
        config = shared_config(clusters, self._rays)
        plan = schedule(self._records[0], self._shelling.geometry, self._shelling.table, config, clusters=clusters,
                        ratio=_RATIO).without_subshells()
        sets = ResidentSets(tuple(np.flatnonzero(home[0] == number) for number in range(clusters)))
        return PhaseRequest(geometry=self._shelling.geometry, table=self._shelling.table, records=records,
                            plan=replace(plan, sets=sets))

    def cast(self, clusters: int, home: np.ndarray, access: Access, *, frames: int | None = None,
             requests: int | None = None) -> JointCast:
        """A frustum of each cluster, behind one from the point before it.

        Parameters
        ----------
        clusters, home, access
            Clusters, a power of two up to 16; where patches are; and how clusters come by them.
        frames, requests
            Patches that a store keeps, and requests that it has in flight. Default: the scene's, and one for
            `Access.SINGLE`, the configuration's for others.
        """
        config, every = shared_config(clusters, self._rays), np.arange(clusters)
        if access is Access.MEMORY:
            home = np.where(home == every[:, None], home, -1)
        timing, joint, bus = cluster_timing(config), joint_timing(config), bus_timing(config, latency=LATENCY)
        store = None
        if access.has_store:
            store = store_timing(config)
            store = replace(store, requests=requests or (1 if access is Access.SINGLE else store.requests))
        others, ahead = home != every[:, None], found_ahead(timing, joint, bus, store)
        before, traces = ([self._trace(clusters, number + step, others[number], ahead) for number in every]
                          for step in (0, 1))
        fetched = [trace.patch[home[number, trace.patch] != number] for number, trace in enumerate(before)]
        stores = {}
        if store:
            made = [store_after(frames or self.frames, patches) for patches in fetched]
            fetched = [each for _, each in made]
            stores = {"stores": [kept for kept, _ in made], "in_order": access is Access.BLOCKING, "store": store}
        kept = in_turn([each[home[number, each] < 0] for number, each in enumerate(fetched)])
        return joint_cast(traces, home, timing, joint, bus=bus, kept=[patch for _, patch in kept], **stores,
                          **joint_options(config))

    def outcome(self, clusters: int, home: np.ndarray, access: Access, *, frames: int | None = None) -> Outcome:
        """The means of such a cast."""
        cast, config = self.cast(clusters, home, access, frames=frames), shared_config(clusters, self._rays)
        timing, owners = joint_timing(config), np.concatenate(cast.owner)
        hops = joint_options(config)["routing"].topology.hops
        on_bus = np.count_nonzero(owners == NO_CLUSTER)
        # Each router on its way sends a packet, the last one to its node.
        routers = sum((hops[number, owner[owner >= 0]] + 1).sum() for number, owner in enumerate(cast.owner))
        counts = {
            "cycles": sum(one.cycles for one in cast.times), "own": np.count_nonzero(owners == -1),
            "kept": np.count_nonzero(owners == KEPT), "remote": np.count_nonzero(owners >= 0),
            "hits": on_bus - cast.reads, "misses": cast.reads, "deferred": cast.deferred.sum(),
            "flits": (timing.request_flits + timing.reply_flits) * routers}
        return Outcome(**{name: float(count / clusters) for name, count in counts.items()})
