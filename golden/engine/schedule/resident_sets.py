"""Resident sets: the patches in each cluster's own memory during a phase."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError
from golden.engine.schedule.usage import usage_order

__all__ = ["ResidentSets", "fill_up", "resident_sets", "spread_sets"]


@dataclass(frozen=True, eq=False)
class ResidentSets:
    """The resident set of each cluster.

    Parameters
    ----------
    patches
        Per cluster int64 patch numbers; the index in the list is the local address.
    """

    patches: tuple[np.ndarray, ...]

    def __len__(self) -> int:
        return sum(len(held) for held in self.patches)

    @property
    def chosen(self) -> np.ndarray:
        """The numbers of all resident patches, cluster by cluster."""
        return np.concatenate(self.patches)

    def residence(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Cluster and local address of each of ``count`` patches, -1 where it is in main memory only."""
        cluster, address = np.full((2, count), -1, dtype=np.int64)
        for number, held in enumerate(self.patches):
            cluster[held], address[held] = number, np.arange(len(held))
        return cluster, address


def resident_sets(patches, cluster, frequency, *, clusters: int, capacity: int | None = None) -> ResidentSets:
    """The patches of each cluster, in the order in which they were found.

    Parameters
    ----------
    patches
        P patch numbers in the order of discovery.
    cluster
        P int, home cluster of each (`classify`).
    frequency
        P int, references to each in the sparse casting.
    capacity
        Patches that a cluster's memory holds; the most used are kept. No limit by default.

    Raises
    ------
    InputError
        Capacity below 0.
    """
    if capacity is not None and capacity < 0:
        raise InputError(f"schedule: Capacity must be at least 0, not {capacity!r}", parameter="capacity")
    patches, cluster, frequency = np.asarray(patches), np.asarray(cluster), np.asarray(frequency)
    held = []
    for number in range(clusters):
        own = np.flatnonzero(cluster == number)
        held.append(patches[own[np.sort(usage_order(frequency[own])[:capacity])]])
    return ResidentSets(tuple(held))


def spread_sets(patches: int, *, clusters: int, capacity: int) -> ResidentSets:
    """The sets without a casting: patch after patch in the next cluster, until all are full.

    Parameters
    ----------
    patches
        Number of patches.
    capacity
        As for `resident_sets`.
    """
    held = np.arange(min(patches, clusters * capacity))
    return ResidentSets(tuple(held[number::clusters] for number in range(clusters)))


def fill_up(sets: ResidentSets, patches: np.ndarray, cluster: np.ndarray, *, capacity: int) -> ResidentSets:
    """Sets with more patches appended, up to the capacity.

    A patch whose home cluster is full is added where most capacity is free: another cluster is nearer than main memory.

    Parameters
    ----------
    sets
        Sets that hold none of ``patches``.
    patches
        Q patch numbers, in the order in which they are added.
    cluster
        Q int, home cluster of each; -1 without a home.
    capacity
        As for `resident_sets`.
    """
    free = np.array([max(0, capacity - len(held)) for held in sets.patches])
    chosen = np.full(len(patches), -1)
    for number, left in enumerate(free):
        chosen[np.flatnonzero(cluster == number)[:left]] = number
    free -= np.bincount(chosen[chosen >= 0], minlength=len(free))
    for index in np.flatnonzero(chosen < 0)[:free.sum()]:
        chosen[index] = free.argmax()
        free[chosen[index]] -= 1
    return ResidentSets(tuple(np.append(held, patches[chosen == number]) for number, held in enumerate(sets.patches)))
