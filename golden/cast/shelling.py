"""Shelling: sparse grid rays open the cells of one shell after the other; each patch found is tested once, at once
against all rays of its window that it may improve.

In the machine's integers. The hits are those of `NaiveFixed` to the bit, whatever the cell size, the order of the
patches and the number of clusters.

Source: Shen 1993, section 3.4; design.md section 5.
"""

from dataclasses import dataclass, fields

import numpy as np

from golden.cast.fixed_hits import FixedHits, read_out
from golden.config import Config
from golden.ctu.sector import Sector
from golden.ctu.unit import CellTraversalUnit
from golden.errors import InputError
from golden.frustum import FrustumRecord
from golden.icu.inverse_distance import encode, inverse_distance
from golden.icu.patch_setup import Patches, PatchSetup
from golden.icu.ray_memory import RayMemory
from golden.icu.screening import cones
from golden.memsys.cell_table import CellTable
from golden.memsys.filter import Filter
from golden.scene.cells import FINEST
from golden.scene.patch_geometry import PatchGeometry

__all__ = ["Shelling", "ShellingCounts", "nearest_settled"]

# Rays of windows looked at together: patches so near each other in time do not see each other's hits.
BLOCK = 1 << 14


@dataclass(kw_only=True)
class ShellingCounts:
    """What one cluster did for one frustum.

    Members
    -------
    rays
        Intersection rays of its section.
    shells
        Shells until no hit could change any more.
    grid_rays, cell_steps
        Grid rays sent out and cells that they visited, cells that had been opened before included.
    cells, patches
        Different cells opened, and patches found in them: each is fetched once.
    in_windows, tests
        Rays in the windows of the patches found, and those of them that were tested.
    """

    rays: int = 0
    shells: int = 0
    grid_rays: int = 0
    cell_steps: int = 0
    cells: int = 0
    patches: int = 0
    in_windows: int = 0
    tests: int = 0

    @property
    def edrc(self) -> float:
        """Tests per patch found: the effective degree of ray coherence."""
        return self.tests / max(1, self.patches)

    def __add__(self, other: "ShellingCounts") -> "ShellingCounts":
        total = ShellingCounts(**{field.name: getattr(self, field.name) + getattr(other, field.name)
                                  for field in fields(self)})
        total.shells = max(self.shells, other.shells)
        return total


class Shelling:
    """Casts the frusta of one scene.

    Parameters
    ----------
    geometry, config
        The patches, and the configuration.
    cell
        Cell size as a share of the scene box's longest side, 1/256 to 1.

    Errors
    ------
    InputError
        Cell size out of range.
    """

    def __init__(self, geometry: PatchGeometry, config: Config, *, cell: float):
        if not 1 / FINEST <= cell <= 1:
            raise InputError(f"Cell size must be 1/{FINEST} to 1 of the scene's longest side, not {cell!r}")
        self._geometry, self._config = geometry, config
        self.table = CellTable(geometry.vertices, cell=geometry.coordinates.cell_size(cell))

    def cast(self, record: FrustumRecord, sectors: tuple[Sector, ...] = (),
             subshells: tuple = (), references: np.ndarray | None = None,
             ray_tests: np.ndarray | None = None) -> tuple[FixedHits, list[ShellingCounts]]:
        """The nearest hit of each ray.

        Parameters
        ----------
        sectors
            The clusters' parts of the frustum, which together hold each ray once. Default: one cluster.
        subshells
            A `SubshellList` for each sector. Default: none but the last subshell, which is all of the sector.
        references
            N int64, to which the tests of each patch are added.
        ray_tests
            R int64, to which the tests of each ray are added.

        Returns
        -------
        The hits, and the counts of each cluster.

        Errors
        ------
        InputError
            The frustum has more rays than ``icu.rays``.
        """
        memory = RayMemory(len(record), self._config)
        patches = PatchSetup(record, self._config).patches(self._geometry)
        tests = _Tests(patches, record, memory, self._config, references, ray_tests)
        sectors = sectors or (Sector.whole(record),)
        counts = [self._cluster(record, sector, listed, tests, memory)
                  for sector, listed in zip(sectors, subshells or [None] * len(sectors), strict=True)]
        return read_out(memory, record, patches, self._config), counts

    def _cluster(self, record, sector, subshells, tests, memory):
        """All subshells of one section; what other clusters do does not matter to it."""
        traversal = CellTraversalUnit(record, self.table, sector)
        cell_filter, patch_filter = Filter(len(self.table)), Filter(len(self._geometry))
        own = sector.mask(record)
        counts = ShellingCounts(rays=int(own.sum()))
        limits = [nearest_settled(traversal.settled(shell), self._config) for shell in range(traversal.last_shell + 1)]
        for number, (shell, window) in enumerate(_schedule(subshells, tests.window, traversal.last_shell)):
            may_change = own & (memory.inverse <= limits[shell]).reshape(own.shape)
            if not may_change.any():
                continue
            counts.shells = max(counts.shells, shell)
            cells = cell_filter.first(traversal.open(shell, may_change, window, subshell=number))
            found = patch_filter.first(self.table.patches.read(self.table.entries(cells)))
            tests.run(found, own.ravel(), counts)
        counts.grid_rays, counts.cell_steps = traversal.grid_rays, traversal.steps
        counts.cells, counts.patches = cell_filter.passed, patch_filter.passed
        return counts


def _schedule(subshells, window, last_shell):
    """Shells and windows in the order in which they are explored: shell 1, the subshells, each from shell 2 to its own,
    and the last subshell, which has no window.
    """
    yield 1, None
    if subshells is not None:
        for patch, end in zip(subshells.patches, subshells.shell, strict=True):
            for shell in range(2, min(end, last_shell) + 1):
                yield shell, window(patch)
    for shell in range(2, last_shell + 1):
        yield shell, None


class _Tests:
    """Tests of patches against the rays of their windows."""

    def __init__(self, patches: Patches, record: FrustumRecord, memory: RayMemory, config: Config, references=None,
                 ray_tests=None):
        self._patches, self._record, self._memory, self._config = patches, record, memory, config
        self._references, self._ray_tests = references, ray_tests
        self._directions = record.all_directions()
        # Products of planes and directions are below 2^53: exact in float64.
        self._components = np.ascontiguousarray(self._directions.T, dtype=np.float64)
        owner, planes = cones(patches.planes)
        order = np.argsort(owner, kind="stable")
        self._planes = np.ascontiguousarray(planes[order].reshape(-1, 12).T, dtype=np.float64)
        self._cone = np.searchsorted(owner[order], np.arange(len(patches.live) + 1))

    def window(self, patch: int) -> tuple[int, int, int, int]:
        """First column, columns, first row and rows of a patch's window."""
        window = self._patches.window[patch]
        return window.column_first, window.column_count, window.row_first, window.row_count

    def run(self, found: np.ndarray, own: np.ndarray, counts: ShellingCounts) -> None:
        """Test patches in this order, as many of them together as `BLOCK` allows."""
        found = found[self._patches.window.rays[found] > 0]
        total = np.cumsum(self._patches.window.rays[found])
        for block in np.split(found, np.searchsorted(total, np.arange(BLOCK, total[-1], BLOCK)) if len(found) else []):
            if len(block):
                self._block(block, own, counts)

    def _block(self, block, own, counts):
        which, column, row = self._patches.window[block].pairs(self._record.columns)
        ray, patch = row * self._record.columns + column, block[which]
        mine = own[ray]
        counts.in_windows += int(np.count_nonzero(mine))
        # Lazy isolation: a ray that already has something nearer than the patch can be is not tested.
        may_improve = np.flatnonzero(mine & (self._memory.inverse[ray] <= self._patches.bound[patch]))
        ray, patch = ray[may_improve], patch[may_improve]
        counts.tests += len(ray)
        if self._references is not None:
            self._references += np.bincount(patch, minlength=len(self._references))
        if self._ray_tests is not None:
            np.add.at(self._ray_tests, ray, 1)
        first, last = self._cone[patch], self._cone[patch + 1] - 1
        hit = self._inside(first, ray)
        two = np.flatnonzero(last > first)
        hit[two] |= self._inside(last[two], ray[two])
        ray, patch = ray[hit], patch[hit]
        inverse = inverse_distance(self._patches.factor[patch], self._directions[ray], self._config.numbers)
        self._memory.update(ray, inverse, patch)

    def _inside(self, cone, ray):
        """Whether ray k is inside cone k."""
        x, y, z = (component.take(ray) for component in self._components)
        inside = np.ones(len(ray), dtype=bool)
        for edge in range(4):
            a, b, c = (component.take(cone) for component in self._planes[3 * edge:3 * edge + 3])
            inside &= a * x + b * y + c * z >= 0
        return inside


def nearest_settled(distance: float, config: Config) -> int:
    """The stored inverse distance of a hit at ``distance``, rounded up; the largest one for no distance."""
    numbers = config.numbers
    if not distance > 0:
        return numbers.inverse.high
    mantissa, exponent = np.frexp(1 / distance)
    return int(encode(np.array(int(np.ceil(mantissa * 2.0**30))), np.array(int(exponent) - 30), numbers, up=True))
