"""Sections: a frustum's rays cut into rectangles of about equal work, one per cluster."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from golden.base.errors import InputError, check_int
from golden.engine.ctu.sector import Sector

__all__ = ["Partition", "cut_sections", "grid_of"]

# A part is (first column, end column, first row, end row); slices for cuts of columns and of rows.
_AXES = (slice(0, 2), slice(2, 4))


def grid_of(parts: int) -> tuple[int, int]:
    """How many of some parts, a power of two, are beside and above each other: cuts alternate, of columns first."""
    cuts = int(parts).bit_length() - 1
    return 1 << (cuts + 1) // 2, 1 << cuts // 2


@dataclass(frozen=True, eq=False)
class Partition:
    """The binary space partition of ``columns`` x ``rows`` rays.

    Parameters
    ----------
    columns, rows
        Size of the dense frustum.
    levels
        Level s holds 2^s parts, int64 2^s x 4: first column, end column, first row, end row. Parts 2 k and 2 k + 1 of
        the next level are the two sides of part k's cut. The last level holds the sections.
    """

    columns: int
    rows: int
    levels: tuple[np.ndarray, ...]

    @cached_property
    def sections(self) -> tuple[Sector, ...]:
        """Section of each cluster; section k is also sector k."""
        return tuple(Sector(*(int(border) for border in part)) for part in self.levels[-1])

    @cached_property
    def cluster_map(self) -> np.ndarray:
        """Rows x columns int64: the section of each ray."""
        owner = np.empty((self.rows, self.columns), dtype=np.int64)
        for number, section in enumerate(self.sections):
            owner[section.first_row:section.end_row, section.first_column:section.end_column] = number
        return owner

    def sums(self, values: np.ndarray) -> np.ndarray:
        """Per section, the sum of ``values`` (rows x columns) over its rays."""
        return np.bincount(self.cluster_map.ravel(), weights=np.asarray(values, dtype=np.float64).ravel(),
                           minlength=len(self.sections))


def cut_sections(workload, *, clusters: int, ray_capacity: int | None = None) -> Partition:
    """Cut a frustum into sections of about equal work.

    Each of log2 ``clusters`` levels cuts every part at the border between rays that is nearest to its median of work,
    alternately in azimuth and in polar angle (screen: in x and y). Of equally good borders the one nearest to the
    middle is chosen, then the lower.

    Parameters
    ----------
    workload
        rows x columns float64, at least 0: the expected work of each ray.
    clusters
        A power of two, at most as many as cuts of columns and of rows can make.
    ray_capacity
        The maximum number of rays of a section. No limit by default.

    Raises
    ------
    InputError
        The number of clusters is no power of two or too large, work is negative or not finite, or even equal cuts leave
        sections with more rays than ``ray_capacity``.
    TypeError
        The number of clusters is no int.

    Source: Shen 1993, Fig. 4.10; the cuts may pass through virtual frusta.
    """
    workload = np.asarray(workload, dtype=np.float64)
    if workload.ndim != 2 or not workload.size or not np.isfinite(workload).all() or workload.min() < 0:
        raise InputError("schedule: Workload must be finite and at least 0 for each ray")
    check_int("schedule: Clusters", clusters)
    if clusters < 1 or clusters & (clusters - 1):
        raise InputError(f"schedule: Clusters must be a power of two, not {clusters!r}", parameter="clusters")
    rows, columns = workload.shape
    # Cuts still to come in columns and in rows, before each level.
    levels = int(clusters).bit_length() - 1
    cuts = [((levels - level + (level + 1) % 2) // 2, (levels - level + level % 2) // 2) for level in range(levels + 1)]
    if columns < 1 << cuts[0][0] or rows < 1 << cuts[0][1]:
        raise InputError(f"schedule: {columns} x {rows} rays cannot be cut for {clusters} clusters")
    largest = _largest(columns, rows, cuts[0])
    ray_capacity = columns * rows if ray_capacity is None else ray_capacity
    if largest > ray_capacity:
        raise InputError(f"schedule: {columns} x {rows} rays on {clusters} clusters are sections of at least {largest} "
                         f"rays, and the capacity is {ray_capacity}")
    total = np.zeros((rows + 1, columns + 1))
    np.cumsum(np.cumsum(workload, axis=0), axis=1, out=total[1:, 1:])
    parts = [np.array([[0, columns, 0, rows]], dtype=np.int64)]
    for level in range(levels):
        sides = [side for part in parts[-1] for side in _cut(total, part, level % 2, cuts[level + 1], ray_capacity)]
        parts.append(np.array(sides, dtype=np.int64))
    return Partition(columns, rows, tuple(parts))


def _largest(columns, rows, cuts):
    """Rays of the largest section that equal cuts leave."""
    return (-columns >> cuts[0]) * (-rows >> cuts[1])


def _cut(total, part, axis, cuts, ray_capacity):
    """The two sides of a part, wide enough for the cuts to come, with at most ``ray_capacity`` rays per section."""
    across, along = part[_AXES[1 - axis]], part[_AXES[axis]]
    first, end = along
    sums = total if axis == 0 else total.T
    done = sums[across[1], first:end + 1] - sums[across[0], first:end + 1]
    done = done - done[0]
    least = 1 << cuts[axis]
    border = np.arange(first + least, end - least + 1)
    larger = np.maximum(border - first, end - border)
    width = across[1] - across[0]
    size = (larger, width) if axis == 0 else (width, larger)
    border, larger = (value[_largest(*size, cuts) <= ray_capacity] for value in (border, larger))
    off = np.abs(done[border - first] - done[-1] / 2)
    at = border[np.lexsort((border, larger, off))[0]]
    low, high = part.copy(), part.copy()
    low[_AXES[axis]] = first, at
    high[_AXES[axis]] = at, end
    return low, high
