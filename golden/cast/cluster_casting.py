"""One cluster casting its section of a frustum, one shell of one subshell after the other."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from golden.config import Config
from golden.ctu.sector import Sector
from golden.ctu.settle_pyramid import SettlePyramid
from golden.ctu.unit import CellTraversalUnit
from golden.frustum import FrustumRecord
from golden.memsys.cell_table import CellTable
from golden.memsys.filter import Filter

__all__ = ["ClusterCasting", "Stage"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Stage:
    """One shell of one subshell: what was opened and found.

    Parameters
    ----------
    subshell
        Its number; the last one is all of the sector. The cells of shell 1 belong to number 0.
    shell, window
        Which; the window as `subshell_rays` takes it, None of the last subshell and of shell 1.
    looked_at, grid_rays, cell_steps, turns
        Grid rays in sector and window, those sent out, cells that they visited, and turns in traversal, see
        `CellTraversalUnit`.
    cells
        In the order in which they were met, as often as they were.
    opened, found
        Cells not opened before, and patches not found before, each once.
    """

    subshell: int
    shell: int
    window: tuple[int, int, int, int] | None
    looked_at: int
    grid_rays: int
    cell_steps: int
    turns: int
    cells: np.ndarray
    opened: np.ndarray
    found: np.ndarray


class ClusterCasting:
    """Opens cells and finds patches; who tests them is asked from outside.

    Parameters
    ----------
    record, sector
        The frustum, and the cluster's part of it.
    table
        The cells.
    patches
        Patches of the scene.
    config
        The configuration.
    by_code
        Survival is judged by settle codes, as the machine does it, rather than by stored inverse distances.
    """

    def __init__(self, record: FrustumRecord, sector: Sector, table: CellTable, *, patches: int, config: Config,
                 by_code: bool):
        self.traversal = CellTraversalUnit(record, table, sector)
        self._record, self._sector, self._table, self._config = record, sector, table, config
        self._by_code, self._own = by_code, sector.mask(record)
        self._cells, self._patches = Filter(len(table)), Filter(patches)

    def schedule(self, subshells, window) -> Iterator[tuple[int, int, tuple | None]]:
        """Number, shell and window of the stages in the order in which they are explored: shell 1, the subshells, each
        from shell 2 to its own, and the last subshell, which has no window.

        Parameters
        ----------
        subshells
            A `SubshellList`, or None: the last one only.
        window
            From the number of a patch to its window.
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
        """One stage, with the stored inverse distances of all rays as survival sees them; None: all have settled.

        Distances from earlier on open more, and never less.
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
        looked_at, grid_rays, steps, turns = np.subtract(_work(traversal), before).tolist()
        opened = self._cells.first(cells)
        found = self._patches.first(self._table.patches.read(self._table.entries(opened)))
        return Stage(subshell=subshell, shell=shell, window=window, looked_at=looked_at, grid_rays=grid_rays,
                     cell_steps=steps, turns=turns, cells=cells, opened=opened, found=found)


def _work(traversal):
    return traversal.looked_at, traversal.grid_rays, traversal.steps, traversal.turns
