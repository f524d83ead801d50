"""Section work: what a cluster of the paper's machine does for a frustum, subshell by subshell, from golden's casting.

Work is that of shells that end one after the other. So it does not depend on times.
"""

from dataclasses import dataclass

import numpy as np

from golden.engine.cast.cluster_casting import Stage
from golden.engine.cast.shelling import Shelling, ShellingCounts, Tests
from golden.engine.config import Config
from golden.engine.ctu.cell_traversal import Traversal
from golden.engine.ctu.sector import Sector, sector_rays
from golden.engine.ctu.survival import survivors
from golden.engine.ctu.unit import CellTraversalUnit, global_directions
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.ray_memory import RayMemory
from golden.engine.memsys.patches.filter import Filter
from radiosity.machines.paper.mean_window import MeanWindow
from radiosity.machines.paper.subshell_grid import SubshellGrid

__all__ = ["PatchWork", "SectionCasting", "SectionWork", "SubshellWork"]


@dataclass(frozen=True, kw_only=True)
class PatchWork:
    """A patch that a subshell finds.

    Parameters
    ----------
    patch
        Its number.
    entries
        Entries of lists that are read from the patch before it in the subshell up to this one.
    rays
        Rays of its window in the section, each of which is checked.
    tests
        The subshells of the same shell whose rays have not hit yet, and how many of these are in the window.
    """

    patch: int
    entries: int
    rays: int
    tests: tuple[tuple[int, int], ...]


@dataclass(frozen=True, kw_only=True)
class SubshellWork:
    """A subshell.

    Parameters
    ----------
    sector, shell
        Numbers of its sector and of its shell.
    scanned, steps
        Grid rays that are checked, and steps from cell to cell.
    needs
        Subshells of the shell before that hold rays near its own and near its grid rays.
    entries
        Entries of lists after the last patch found.
    patches
        The patches that it finds, in order.
    """

    sector: int
    shell: int
    scanned: int
    steps: int
    needs: tuple[int, ...]
    entries: int
    patches: tuple[PatchWork, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class SectionWork:
    """A section's work.

    Parameters
    ----------
    subshells
        Shell after shell, sector after sector, row by row.
    extents
        Of each shell, columns and rows of its subshells.
    """

    subshells: tuple[SubshellWork, ...]
    extents: tuple[tuple[int, int], ...]

    @property
    def tests(self) -> int:
        """Intersection tests."""
        return sum(count for one in self.subshells for patch in one.patches for _, count in patch.tests)

    @property
    def steps(self) -> int:
        """Steps from cell to cell."""
        return sum(one.steps for one in self.subshells)

    @property
    def patches(self) -> int:
        """Patches found."""
        return sum(len(one.patches) for one in self.subshells)


class SectionCasting:
    """Casts the section of a cluster, shell after shell.

    Subshells of a shell are as large as the mean window of the patches found two shells before and earlier, since a
    shell begins when the shell before the last one has ended. Those of the first shells are whole sectors.

    Parameters
    ----------
    shelling, record, config
        Golden's casting, the frustum, and the configuration of ``shelling``.
    tests, memory
        The tests of the frustum's patches, and its rays.
    section, sectors
        The section of the cluster's intersection unit, and the sectors of its traversal units: a partition of it.
    """

    def __init__(self, shelling: Shelling, record: FrustumRecord, config: Config, *, tests: Tests, memory: RayMemory,
                 section: Sector, sectors: tuple[Sector, ...]):
        self._record, self._config, self._table = record, config, shelling.table
        self._tests, self._memory, self._section = tests, memory, section
        self._units = [CellTraversalUnit(record, shelling.table, sector) for sector in sectors]
        self._masks = [sector.mask(record) for sector in sectors]
        self._own = section.mask(record)
        self._cells, self._patches = Filter(len(shelling.table)), Filter(len(shelling.geometry))
        self._mean, self._extents = MeanWindow(), None
        # Of each sector the subshells of the shell before, and the number of the first one.
        self._before = None

    def run(self) -> SectionWork:
        """The work of all shells; the ray memory then has the hits of the section."""
        subshells, extents = [], []
        for shell in range(1, self._units[0].last_shell + 1):
            may_change = self._memory.inverse <= self._units[0].limit(shell, self._config)
            live = self._own & may_change.reshape(self._own.shape)
            if not live.any():
                break
            extents.append(self._extents or (self._record.columns, self._record.rows))
            self._extents = self._mean.extents
            subshells += self._shell(shell, extents[-1], live, first=len(subshells))
        return SectionWork(subshells=tuple(subshells), extents=tuple(extents))

    def _shell(self, shell, extents, live, *, first):
        """The subshells of a shell, numbered from ``first``; their patches are tested."""
        grids = [SubshellGrid(sector=unit.sector, columns=self._record.columns, extents=extents)
                 for unit in self._units]
        firsts = np.cumsum([first, *map(len, grids)]).tolist()
        sent = [self._sent(sector, shell, grid, live) for sector, grid in enumerate(grids)]
        found = [self._found(cells) for _, _, by_subshell, _ in sent for cells in by_subshell]
        patches = iter(self._tested(np.concatenate([one for one, _, _ in found]), grids, firsts, live))
        made, reads = [], iter(found)
        for sector, (scanned, steps, _, needs) in enumerate(sent):
            for subshell in range(len(grids[sector])):
                _, entries, rest = next(reads)
                made.append(SubshellWork(
                    sector=sector, shell=shell, scanned=int(scanned[subshell]), steps=int(steps[subshell]),
                    needs=needs[subshell], entries=rest,
                    patches=tuple(PatchWork(patch=patch, entries=count, rays=rays, tests=tests)
                                  for count, (patch, rays, tests) in zip(entries, patches, strict=False))))
        self._before = list(zip(grids, firsts, strict=False))
        return made

    def _sent(self, sector, shell, grid, live):
        """The grid rays of a sector: by subshell those checked, steps, cells in the order of steps, and needs."""
        if shell == 1:
            near = self._units[sector].open(1, live) if sector == 0 else np.empty(0, dtype=np.int64)
            return [0], [len(near)], [near], [()]
        unit, record = self._units[sector], self._record
        rays = unit.rays(shell)
        owner, inside = grid.of_grid_rays(rays).ravel(), sector_rays(rays, unit.sector, record).ravel()
        sent = np.flatnonzero(inside & survivors(rays, live & self._masks[sector]).ravel())
        begin, end = unit.borders(shell)
        traversal = Traversal(self._table.position(record.origin), global_directions(
            rays.direction.reshape(-1, 3)[sent], record), begin=begin, end=end, shape=self._table.shape)
        # A ray that never enters the grid takes a step too.
        never = np.ones(len(sent), dtype=bool)
        never[traversal.ray] = False
        passes, cells = [owner[sent[never]]], [(np.empty(0, dtype=np.int64),) * 2]
        while len(traversal.ray):
            of_subshell = owner[sent[traversal.ray]]
            passes.append(of_subshell)
            cells.append((of_subshell[traversal.inside], self._table.number(traversal.index[traversal.inside])))
            traversal.advance()
        of_subshell, cells = (np.concatenate(each) for each in zip(*cells, strict=True))
        order = np.argsort(of_subshell, kind="stable")
        borders = np.searchsorted(of_subshell[order], np.arange(1, len(grid)))
        return (np.bincount(owner[inside], minlength=len(grid)),
                np.bincount(np.concatenate(passes), minlength=len(grid)),
                np.split(cells[order], borders), self._needs(sector, grid, rays, owner, inside))

    def _needs(self, sector, grid, rays, owner, inside):
        """Of each subshell those of the shell before that hold its rays, and rays near its grid rays."""
        before, first = self._before[sector]
        near = (rays.row_count[:, None] > 0) & (rays.column_count > 0)
        some = np.flatnonzero(inside & near.ravel())
        windows = (np.broadcast_to(value, near.shape).ravel()[some] for value in (
            rays.first_column, rays.column_count, rays.first_row[:, None], rays.row_count[:, None]))
        ranges = before.ranges(*grid.windows)
        for extreme, range_, other in zip((np.minimum, np.maximum) * 2, ranges, before.ranges(*windows), strict=True):
            extreme.at(range_, owner[some], other)
        columns = before.shape[1]
        return [tuple(first + row * columns + column for row in range(top, bottom + 1)
                      for column in range(left, right + 1))
                for top, bottom, left, right in zip(*(range_.tolist() for range_ in ranges), strict=True)]

    def _found(self, cells):
        """Patches in the cells that are opened, entries read from one to the next, and entries after the last."""
        opened = self._cells.first(cells)
        listed = self._table.patches.read(self._table.entries(opened))
        new = self._patches.first(listed)
        numbers, where = np.unique(listed, return_index=True)
        where = where[np.searchsorted(numbers, new)]
        last = int(where[-1]) if len(where) else -1
        return new, np.diff(where, prepend=-1).tolist(), len(listed) - 1 - last

    def _tested(self, found, grids, firsts, live):
        """Of each patch its number, its rays in the section, and its tests by subshell; then test them."""
        windows = self._tests.patches.window[found]
        self._mean.add(windows)
        owner = np.full(self._own.shape, -1)
        for grid, first in zip(grids, firsts, strict=False):
            row, column = np.mgrid[grid.sector.first_row:grid.sector.end_row,
                                   grid.sector.first_column:grid.sector.end_column]
            owner[row, column] = first + grid.numbers(column, row)
        which, column, row = windows.pairs(self._record.columns)
        inside, tested = self._own[row, column], live[row, column]
        rays = np.bincount(which[inside], minlength=len(found)).tolist()
        most = int(owner.max()) + 1
        pairs, count = np.unique(which[tested] * most + owner[row, column][tested], return_counts=True)
        tests = [[] for _ in rays]
        for pair, tests_of_pair in zip(pairs.tolist(), count.tolist(), strict=True):
            tests[pair // most].append((pair % most, tests_of_pair))
        none = np.empty(0, dtype=np.int64)
        self._tests.run(Stage(subshell=0, shell=1, window=None, scanned=0, grid_rays=0, cell_steps=0, passes=0,
                              cells=none, opened=none, found=found), self._section, ShellingCounts())
        return list(zip(found.tolist(), rays, map(tuple, tests), strict=True))
