"""Shelling in fixed point.

Sparse grid rays open the cells of one shell after the other. Each patch found is tested once, against all rays of its
window that it may improve. The hits are bit-exact with `NaiveFixed` for every cell size, order of patches and number of
clusters.

Source: Shen 1993, section 3.4; docs/exactness.md derives the margins.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np

from golden.engine.cast.cluster_casting import ClusterCasting, Stage
from golden.engine.cast.fixed_hits import FixedHits, read_out
from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.frustum import FrustumRecord
from golden.engine.frustum.bundle import Bundle
from golden.engine.frustum.shadow_record import ShadowRecord
from golden.engine.icu.inverse_distance import inverse_distance
from golden.engine.icu.patch_setup import Patches, PatchSetup
from golden.engine.icu.ray_memory import RayMemory
from golden.engine.icu.screening import cones
from golden.engine.icu.section_clip import section_clip
from golden.engine.icu.shadow_memory import ShadowMemory
from golden.engine.icu.window_walk import issue_cycles, walk_cycles
from golden.engine.memsys.patches.cell_table import MARGIN, CellTable
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.cells import check_cell_size

__all__ = ["Shelling", "ShellingCounts", "Tests"]

# Rays of windows per block: patches of one block are tested with the inverse distances before the block.
BLOCK = 1 << 14


@dataclass(kw_only=True)
class ShellingCounts:
    """Counts of one cluster for one frustum.

    Members
    -------
    rays
        Intersection rays of its section.
    shells
        The last shell with a ray that could still change.
    scanned, grid_rays, cell_steps, passes
        Grid rays scanned in the subshells' windows, grid rays issued, cells that they visited (with repetitions), and
        traversal passes, see `CellTraversalUnit`.
    cells, patches
        Different cells opened, and patches found in them: each is fetched once.
    in_windows, tests
        Rays in the windows of the patches found, and those of them that were tested.
    walk_cycles
        Cycles in which the machine scans the windows, a tile or a test in each.
    """

    rays: int = 0
    shells: int = 0
    scanned: int = 0
    grid_rays: int = 0
    cell_steps: int = 0
    passes: int = 0
    cells: int = 0
    patches: int = 0
    in_windows: int = 0
    tests: int = 0
    walk_cycles: int = 0

    @property
    def edrc(self) -> float:
        """Tests per patch found: the estimated degree of ray coherence."""
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
    by_code
        The survival test compares settle codes, as in the machine. It opens more cells; the hits are the same.
    ascending
        See `CellTable`. The hits are the same.

    Members
    -------
    geometry, table
        The patches, and the cells.

    Raises
    ------
    InputError
        Cell size out of range.
    """

    def __init__(self, geometry: PatchGeometry, config: Config, *, cell: float, by_code: bool = False,
                 ascending: int | None = None):
        check_cell_size(cell)
        self.geometry, self._config, self._by_code = geometry, config, by_code
        self.table = CellTable(geometry.vertices, cell=geometry.coordinates.cell_size(cell), ascending=ascending,
                               margin=max(MARGIN, 1 << config.numbers.scene_bits - config.numbers.vector_fraction))

    @classmethod
    def of_cells(cls, geometry: PatchGeometry, table: CellTable, config: Config, *,
                 by_code: bool = False) -> "Shelling":
        """Casts in cells that are made already."""
        made = cls.__new__(cls)
        made.geometry, made.table, made._config, made._by_code = geometry, table, config, by_code
        return made

    def cast(self, record: FrustumRecord, sectors: tuple[Sector, ...] = (),
             subshells: tuple = (), *, references: np.ndarray | None = None,
             ray_tests: np.ndarray | None = None) -> tuple[FixedHits, list[ShellingCounts]]:
        """The nearest hit of each ray.

        Parameters
        ----------
        sectors
            The clusters' parts of the frustum: a partition of its rays. Default: one cluster.
        subshells
            A `SubshellList` for each sector. Default: the last subshell only, which is the whole sector.
        references
            N int64, to which the tests of each patch are added.
        ray_tests
            R int64, to which the tests of each ray are added.

        Returns
        -------
        The hits, and the counts of each cluster.

        Raises
        ------
        InputError
            The frustum has more rays than ``icu.rays``.
        """
        memory = RayMemory(len(record), self._config)
        tests = self.tests(record, memory, references=references, ray_tests=ray_tests)
        sectors = sectors or (Sector.whole(record),)
        counts = [self._cluster(record, sector, listed, tests, memory)
                  for sector, listed in zip(sectors, subshells or [None] * len(sectors), strict=True)]
        return read_out(memory, record, tests.patches, self._config), counts

    def blocked(self, record: ShadowRecord, *, ray_tests: np.ndarray | None = None
                ) -> tuple[np.ndarray, ShellingCounts]:
        """Whether anything is before the end of each ray of a shadow frustum, R bool, and the counts.

        ``ray_tests`` and the exceptions are those of `cast`.
        """
        memory = ShadowMemory(record, self._config)
        tests = self.tests(record, memory, ray_tests=ray_tests)
        return memory.blocked, self._cluster(record, Sector.whole(record), None, tests, memory)

    def _cluster(self, record, sector, subshells, tests, memory):
        """All subshells of one section; clusters do not depend on each other."""
        counts = ShellingCounts(rays=int(sector.mask(record).sum()))
        for _ in self.stages(record, sector, subshells, tests, memory, counts):
            pass
        return counts

    def stages(self, record: FrustumRecord, sector: Sector, subshells, tests: "Tests",
               memory: RayMemory | ShadowMemory, counts: ShellingCounts) -> Iterator[Stage]:
        """The stages of one section, each tested, and counted, before the next one, which sees its hits."""
        cluster = self.cluster(record, sector)
        for where in cluster.schedule(subshells, tests.window):
            stage = cluster.explore(*where, memory.inverse)
            if stage is not None:
                tests.run(stage, sector, counts)
                yield stage

    def cluster(self, record: FrustumRecord, sector: Sector) -> ClusterCasting:
        """A cluster before its first stage of a frustum."""
        return ClusterCasting(record, sector, self.table, patches=len(self.geometry), config=self._config,
                              by_code=self._by_code)

    def memory(self, record: FrustumRecord) -> RayMemory | ShadowMemory:
        """The ray memory of a frustum of any kind before its first patch; see `cast` for the exceptions."""
        return ShadowMemory(record, self._config) if record.bundle == Bundle.SHADOW else RayMemory(
            len(record), self._config)

    def tests(self, record: FrustumRecord, memory: RayMemory | ShadowMemory, *, references=None, ray_tests=None,
              block: int = BLOCK, lanes: int = 1) -> "Tests":
        """The tests of a frustum's rays, see `cast` and `Tests`; ``block`` rays of windows at once."""
        patches = PatchSetup(record, self._config).patches(self.geometry)
        return Tests(patches, record, memory, self._config, references=references, ray_tests=ray_tests, block=block,
                     lanes=lanes)


class Tests:
    """Tests of patches against the rays of their windows.

    Members
    -------
    patches
        The patches, set up for the frustum.
    issued
        P int64: of each patch so far, the cycles in which its rays are issued, up to ``lanes`` of a tile in each.
    """

    def __init__(self, patches: Patches, record: FrustumRecord, memory: RayMemory, config: Config, *,
                 references=None, ray_tests=None, block: int = BLOCK, lanes: int = 1):
        self._size = block
        self.patches, self._record, self._memory, self._config = patches, record, memory, config
        self._references, self._ray_tests = references, ray_tests
        self.issued, self._lanes = np.zeros(len(patches.live), dtype=np.int64), lanes
        self._directions = record.all_directions()
        # Products of planes and directions are below 2^53: exact in float64.
        self._components = np.ascontiguousarray(self._directions.T, dtype=np.float64)
        owner, planes = cones(patches.planes)
        order = np.argsort(owner, kind="stable")
        self._planes = np.ascontiguousarray(planes[order].reshape(-1, 12).T, dtype=np.float64)
        self._cone = np.searchsorted(owner[order], np.arange(len(patches.live) + 1))

    def window(self, patch: int) -> tuple[int, int, int, int]:
        """First column, columns, first row and rows of a patch's window."""
        window = self.patches.window[patch]
        return window.column_first, window.column_count, window.row_first, window.row_count

    def run(self, stage: Stage, section: Sector, counts: ShellingCounts) -> None:
        """Test the patches found, in blocks of up to ``block`` rays, and add the stage's counts."""
        own = section.mask(self._record).ravel()
        found = stage.found[self.patches.window.rays[stage.found] > 0]
        total = np.cumsum(self.patches.window.rays[found])
        borders = np.arange(self._size, total[-1], self._size) if len(found) else []
        for block in np.split(found, np.searchsorted(total, borders)):
            if len(block):
                self._block(block, own, section, counts)
        counts.shells = max(counts.shells, stage.shell)
        counts.scanned += stage.scanned
        counts.grid_rays += stage.grid_rays
        counts.cell_steps += stage.cell_steps
        counts.passes += stage.passes
        counts.cells += len(stage.opened)
        counts.patches += len(stage.found)
        # A window without rays takes one cycle.
        counts.walk_cycles += len(stage.found) - len(found)

    def _block(self, block, own, section, counts):
        which, column, row = self.patches.window[block].pairs(self._record.columns)
        ray, patch = row * self._record.columns + column, block[which]
        mine = own[ray]
        counts.in_windows += int(np.count_nonzero(mine))
        # Lazy isolation: a ray whose hit is nearer than the patch can be is not tested.
        may_improve = np.flatnonzero(mine & (self._memory.inverse[ray] <= self.patches.bound[patch]))
        ray, patch = ray[may_improve], patch[may_improve]
        counts.tests += len(ray)
        clip = section_clip(self.patches.window[block], section, self._record)
        which = which[may_improve]
        live = np.bincount(which, minlength=len(block))
        if self._lanes > 1:
            live = issue_cycles(which, ray % self._record.columns - section.first_column,
                                ray // self._record.columns - section.first_row, self._lanes, self._config.icu)
            live = np.pad(live, (0, len(block) - len(live)))
        self.issued[block] += live
        counts.walk_cycles += int(walk_cycles(clip, live, self._config.icu).sum())
        if self._references is not None:
            self._references += np.bincount(patch, minlength=len(self._references))
        if self._ray_tests is not None:
            np.add.at(self._ray_tests, ray, 1)
        first, last = self._cone[patch], self._cone[patch + 1] - 1
        hit = self._inside(first, ray)
        two = np.flatnonzero(last > first)
        hit[two] |= self._inside(last[two], ray[two])
        ray, patch = ray[hit], patch[hit]
        inverse = inverse_distance(self.patches.factor[patch], self._directions[ray], self._config.numbers)
        self._memory.update(ray, inverse, patch)

    def _inside(self, cone, ray):
        """Whether ray k is inside cone k: K bool."""
        x, y, z = (component.take(ray) for component in self._components)
        inside = np.ones(len(ray), dtype=bool)
        for edge in range(4):
            a, b, c = (component.take(cone) for component in self._planes[3 * edge:3 * edge + 3])
            inside &= a * x + b * y + c * z >= 0
        return inside
