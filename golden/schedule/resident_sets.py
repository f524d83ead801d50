"""Resident sets: the patches that each cluster's own memory holds during a phase."""

from dataclasses import dataclass

import numpy as np

from golden.errors import InputError
from golden.schedule.usage import usage_order

__all__ = ["ResidentSets", "fill_up", "resident_sets"]


@dataclass(frozen=True, eq=False)
class ResidentSets:
    """Who holds what.

    Parameters
    ----------
    patches
        Per cluster, int64 patch numbers; the place in the list is the local address.
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
        P, the cluster of each (`classify`).
    frequency
        P, references to each in the sparse casting.
    capacity
        Patches that a cluster's memory holds; the most used stay. No limit by default.

    Raises
    ------
    InputError
        Capacity below 0.
    """
    if capacity is not None and capacity < 0:
        raise InputError(f"schedule: Capacity must be at least 0, not {capacity!r}")
    patches, cluster, frequency = np.asarray(patches), np.asarray(cluster), np.asarray(frequency)
    held = []
    for number in range(clusters):
        own = np.flatnonzero(cluster == number)
        held.append(patches[own[np.sort(usage_order(frequency[own])[:capacity])]])
    return ResidentSets(tuple(held))


def fill_up(sets: ResidentSets, patches: np.ndarray, cluster: np.ndarray, *, capacity: int) -> ResidentSets:
    """Sets with more patches behind those that they have, as far as there is room.

    What finds no room in its own cluster goes where most is left: another cluster is nearer than main memory.

    Parameters
    ----------
    sets
        None of ``patches`` is in them.
    patches
        Q patch numbers; the first ones are taken first.
    cluster
        Q, the cluster of each; -1 of a patch that is at home nowhere.
    capacity
        As for `resident_sets`.
    """
    room = np.array([max(0, capacity - len(held)) for held in sets.patches])
    goes = np.full(len(patches), -1)
    for number, left in enumerate(room):
        goes[np.flatnonzero(cluster == number)[:left]] = number
    room -= np.bincount(goes[goes >= 0], minlength=len(room))
    for place in np.flatnonzero(goes < 0)[:room.sum()]:
        goes[place] = room.argmax()
        room[goes[place]] -= 1
    return ResidentSets(tuple(np.append(held, patches[goes == number]) for number, held in enumerate(sets.patches)))
