"""The schedule of a phase: what its castings share, from one sparse casting."""

from dataclasses import dataclass, replace

import numpy as np

from golden.base.errors import InputError
from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.noc.topology import Topology
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.assignment import heaviest_to_nearest, traffic
from golden.engine.schedule.classification import classify
from golden.engine.schedule.low_density import LowDensity, low_density
from golden.engine.schedule.resident_sets import ResidentSets, fill_up, resident_sets
from golden.engine.schedule.sections import Partition, cut_sections
from golden.engine.schedule.subshells import NO_SUBSHELLS, SubshellList, subshell_lists

__all__ = ["Schedule", "machine_schedule", "schedule"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Schedule:
    """Parameters of a phase, from the host to the machine.

    Parameters
    ----------
    found
        The sparse casting from the reference point.
    partition
        Sections; section k is also sector k.
    cluster
        P int64, home cluster of each patch of ``found``.
    sets, subshells
        Resident set and subshell list of each cluster.
    processor
        The processor of each cluster.
    """

    found: LowDensity
    partition: Partition
    cluster: np.ndarray
    sets: ResidentSets
    subshells: tuple[SubshellList, ...]
    processor: np.ndarray

    @property
    def estimated(self) -> np.ndarray:
        """Expected intersection tests of each cluster: N float64."""
        return self.partition.sums(self.found.frusta.share(self.found.tests))

    @property
    def estimated_steps(self) -> np.ndarray:
        """Expected cell traversal steps of each cluster, without those beyond its sector's border: N float64."""
        return self.partition.sums(self.found.frusta.share(self.found.steps))

    def without_subshells(self) -> "Schedule":
        """With no subshell but the last one, which is not listed: the hits are the same."""
        return replace(self, subshells=(NO_SUBSHELLS,) * len(self.subshells))


def machine_schedule(record: FrustumRecord, geometry: PatchGeometry, table: CellTable, config: Config, *,
                     ratio: int) -> Schedule:
    """`schedule` for the machine of a configuration: its clusters, their capacities, its rule for resident sets.

    Without subshell lists (``ctu.subshell_bits`` of 0) the lists are empty.
    """
    made = schedule(record, geometry, table, config, clusters=config.noc.clusters, ratio=ratio,
                    ray_capacity=config.icu.rays, capacity=config.memsys.own_patches,
                    fill=config.memsys.resident_set == "filled")
    return made if config.ctu.subshells else made.without_subshells()


def schedule(record: FrustumRecord, geometry: PatchGeometry, table: CellTable, config: Config, *, clusters: int,
             ratio: int, ray_capacity: int | None = None, capacity: int | None = None, fill: bool = False,
             topology: str | None = None) -> Schedule:
    """Schedule a phase.

    Parameters
    ----------
    record
        The dense frustum at the reference point.
    geometry, table
        Patches and cells of the scene.
    config
        The configuration.
    clusters
        Number of clusters, a power of two.
    ratio
        Dense rays per sparse ray.
    ray_capacity, capacity
        The maximum numbers of rays and of patches of a cluster. No limits by default.
    fill
        Fill the rest of the capacity with all other patches: first with those found that exceeded a capacity, then
        with those in the cells of the sparse rays that none of these rays meets (dense rays meet some of them), then
        with the rest of the scene.
    topology
        Assign the heaviest traffic to the nearest processors of this network. Default: cluster i is processor i.

    Raises
    ------
    InputError
        See `low_density`, `cut_sections`, `resident_sets`, `Topology`; or there is no capacity to fill.

    Source: Shen 1993, section 4.4.2.
    """
    if fill and capacity is None:
        raise InputError("schedule: Capacity must be given where sets are filled, not None", parameter="capacity")
    found = low_density(record, geometry, table, config, ratio=ratio)
    partition = cut_sections(found.frusta.share(found.tests), clusters=clusters, ray_capacity=ray_capacity)
    cluster = classify(partition, found.window)
    sets = resident_sets(found.patches, cluster, found.frequency[found.patches], clusters=clusters, capacity=capacity)
    subshells = subshell_lists(found, sets, partition)
    if fill:
        # A patch whose window has no ray has no home.
        home, window = np.full(len(geometry), -1), found.passed_window
        home[found.patches] = cluster
        home[found.passed] = np.where((window.row_count > 0) & (window.column_count > 0),
                                      classify(partition, window), -1)
        known = np.concatenate([found.patches, found.passed])
        more = np.concatenate([known, np.setdiff1d(np.arange(len(geometry)), known)])
        more = more[~np.isin(more, sets.chosen)]
        sets = fill_up(sets, more, home[more], capacity=capacity)
    processor = np.arange(clusters) if topology is None else heaviest_to_nearest(
        traffic(partition, found.window, cluster), Topology.of(topology, clusters).hops)
    return Schedule(found=found, partition=partition, cluster=cluster, sets=sets,
                    subshells=subshells, processor=processor)
