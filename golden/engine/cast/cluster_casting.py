"""One cluster casts its section of a frustum, one shell of one subshell after the other."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.ctu.settle_pyramid import SettlePyramid
from golden.engine.ctu.unit import CellTraversalUnit
from golden.engine.frustum import FrustumRecord
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.memsys.patches.filter import Filter

__all__ = ["ClusterCasting", "Stage"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Stage:
    """One shell of one subshell: cells opened and patches found.

    Parameters
    ----------
    subshell
        Number of the subshell; the last one is the whole sector. The cells of shell 1 belong to number 0.
    shell, window
        Number of the shell, and the window of the subshell (`subshell_rays`): None for the last subshell and shell 1.
    scanned, grid_rays, cell_steps, passes
        Grid rays in sector and window, grid rays issued, cells that they visited, and traversal passes, see
        `CellTraversalUnit`.
    cells
        Cell numbers in the order in which grid rays met them, with repetitions.
    opened, found
        Cells not opened before, and patches not found before, each once.
    """

    subshell: int
    shell: int
    window: tuple[int, int, int, int] | None
    scanned: int
    grid_rays: int
    cell_steps: int
    passes: int
    cells: np.ndarray
    opened: np.ndarray
    found: np.ndarray


class ClusterCasting:
    """Opens cells and finds patches; the caller tests them.

    Parameters
    ----------
    record, sector
        The frustum, and the cluster's part of it.
    table
        The cells.
    patches
        Number of patches of the scene.
    config
        The configuration.
    by_code
        The survival test compares settle codes, as in the machine, instead of stored inverse distances.

    Members
    -------
    traversal
        The cell traversal unit, with its counts.
    """

    def __init__(self, record: FrustumRecord, sector: Sector, table: CellTable, *, patches: int, config: Config,
                 by_code: bool):
        self.traversal = CellTraversalUnit(record, table, sector)
        self._record, self._sector, self._table, self._config = record, sector, table, config
        self._by_code, self._own = by_code, sector.mask(record)
        self._cells, self._patches = Filter(len(table)), Filter(patches)

    def schedule(self, subshells, window) -> Iterator[tuple[int, int, tuple | None]]:
        """Subshell, shell and window of the stages in the order of their exploration.

        Shell 1 is first. Each subshell follows, from shell 2 to its own shell, then the last subshell, which has no
        window.

        Parameters
        ----------
        subshells
            A `SubshellList`, or None: the last subshell only.
        window
            Function from the number of a patch to its window.
        """
        last, number = self.traversal.last_shell, 0
        yield 0, 1, None
        if subshells is not None:
            for number, (patch, end) in enumerate(zip(subshells.patches, subshells.shell, strict=True)):
                for shell in range(2, min(end, last) + 1):
                    yield number, shell, window(patch)
            number = len(subshells)
        for shell in range(2, last + 1):
            yield number, shell, None

    def explore(self, subshell: int, shell: int, window, inverse: np.ndarray) -> Stage | None:
        """Explore one stage; None if all rays have settled.

        Parameters
        ----------
        subshell, shell, window
            The stage, see `schedule`.
        inverse
            R int64, stored inverse distances for the survival test. Outdated distances open a superset of the cells.
        """
        traversal, shape = self.traversal, self._own.shape
        threshold = traversal.threshold(shell, self._config) if self._by_code else None
        if self._by_code:
            seen = SettlePyramid.of(inverse.reshape(shape), self._sector, self._config)
            some = seen.live(threshold).any()
        else:
            seen = self._own & (inverse <= traversal.limit(shell, self._config)).reshape(shape)
            some = seen.any()
        if not some:
            return None
        before = _work(traversal)
        cells = traversal.open(shell, seen, window, subshell=subshell, threshold=threshold)
        scanned, grid_rays, steps, passes = np.subtract(_work(traversal), before).tolist()
        opened = self._cells.first(cells)
        found = self._patches.first(self._table.patches.read(self._table.entries(opened)))
        return Stage(subshell=subshell, shell=shell, window=window, scanned=scanned, grid_rays=grid_rays,
                     cell_steps=steps, passes=passes, cells=cells, opened=opened, found=found)


def _work(traversal):
    return traversal.scanned, traversal.grid_rays, traversal.steps, traversal.passes
