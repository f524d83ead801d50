"""Subshell lists: the order in which a cluster's cell traversal unit explores its sector."""

from dataclasses import dataclass

import numpy as np

from golden.engine.schedule.low_density import LowDensity
from golden.engine.schedule.resident_sets import ResidentSets
from golden.engine.schedule.sections import Partition

__all__ = ["NO_SUBSHELLS", "SubshellList", "subshell_lists"]


@dataclass(frozen=True, eq=False)
class SubshellList:
    """The subshells of one cluster; the last subshell, the whole sector to the last shell, follows and is not listed.

    Parameters
    ----------
    patches
        S int64: each subshell is the window of one patch; the machine computes the window for each frustum.
    shell
        S int64, not decreasing: the grid rays of the window end with this shell.
    """

    patches: np.ndarray
    shell: np.ndarray

    def __len__(self) -> int:
        return len(self.patches)


NO_SUBSHELLS = SubshellList(*np.zeros((2, 0), dtype=np.int64))
"""Of a cluster that explores its sector at once."""


def subshell_lists(found: LowDensity, sets: ResidentSets, partition: Partition) -> tuple[SubshellList, ...]:
    """The subshells of each cluster, from its resident patches in the order of their discovery.

    The strategy is speculative. Where no earlier patch is in front, a patch's window is explored at once through all
    shells up to its own: depth first, since the region is probably empty. Where there is one, its subshell precedes,
    and rays continue from its shell when their intersections are known: breadth first, since they probably hit. A
    subshell with only rays that are already in its shell would be skipped ray by ray, and is omitted.

    Source: Shen 1993, section 4.4.2.4; the version and presence rules of Fig. 5.10 split the windows.
    """
    entry = np.full(len(found.frequency), -1, dtype=np.int64)
    entry[found.patches] = np.arange(len(found.patches))
    return tuple(_list(found, entry[held], sector) for held, sector in zip(sets.patches, partition.sections,
                                                                         strict=True))


def _list(found, entries, sector):
    """The subshells of the found patches ``entries`` in one sector."""
    frusta, shell = found.frusta, found.shell[entries]
    overlap = found.frusta.overlaps(found.window[entries])
    inside = (overlap.column * frusta.width < sector.end_column) & (overlap.row * frusta.height < sector.end_row) \
        & ((overlap.column + 1) * frusta.width > sector.first_column) \
        & ((overlap.row + 1) * frusta.height > sector.first_row)
    frustum = overlap.row[inside] * frusta.shape[1] + overlap.column[inside]
    entry = overlap.window[inside]
    order = np.argsort(entry, kind="stable")
    frustum, entry = frustum[order], entry[order]
    # The first entry of each shell explores a frustum from where earlier entries of it have ended.
    moves = np.unique(shell[entry] * (frusta.shape[0] * frusta.shape[1]) + frustum, return_index=True)[1]
    kept = np.unique(entry[moves])
    return SubshellList(found.patches[entries[kept]], shell[kept])
