"""The cell-traversal unit of one cluster: which cells it opens in which shell."""

import numpy as np

from golden.config import Config
from golden.ctu import margins
from golden.ctu.cell_traversal import BEGIN_BITS, NEVER, PLACE_FRACTION, Traversal
from golden.ctu.grid_rays import hemisphere_rays, screen_rays
from golden.ctu.near_cells import near_cells
from golden.ctu.ray_memory import RayMemory
from golden.ctu.sector import Sector, sector_rays, subshell_rays
from golden.ctu.settle_pyramid import SettlePyramid
from golden.ctu.survival import survivors, survivors_by_code
from golden.errors import InputError
from golden.fixed import round_shift
from golden.frustum import FrustumRecord
from golden.icu.inverse_distance import encode
from golden.icu.settle_code import settle_threshold
from golden.memsys.cell_table import CellTable

__all__ = ["CellTraversalUnit", "global_directions"]


class CellTraversalUnit:
    """Opens the cells of one frustum's sector, shell by shell.

    Parameters
    ----------
    record
        The frustum.
    table
        The cells.
    sector
        The cluster's part of it. Default: all of it.

    Members
    -------
    last_shell
        No cell has its centre beyond this shell.
    looked_at, grid_rays, steps, turns
        Grid rays of what was to be opened, those sent out, cells that they have visited, and turns in traversal:
        outside the grid too, and one for a ray that never comes to it.

    Raises
    ------
    InputError
        Directions are too coarse for the cells, or a traversal's parameters are too short: the field of view is too
        wide, or the cells are too small.
    """

    def __init__(self, record: FrustumRecord, table: CellTable, sector: Sector | None = None):
        self.record, self.table = record, table
        self.sector = sector or Sector.whole(record)
        self._own = self.sector.mask(record)
        self._place = table.place(record.origin)
        self.looked_at = self.grid_rays = self.steps = self.turns = 0
        self._memories: dict[int, RayMemory] = {}
        corners = np.array(np.meshgrid(*np.stack([table.lower, table.lower + table.cell * table.shape], axis=1)))
        offset = corners.reshape(3, -1).T - record.origin
        if record.is_screen:
            distance = (offset @ record.matrix[2]).max() / record.z_scale
        else:
            distance = np.sqrt((offset * offset).sum(axis=1).max())
        self.last_shell = max(1, int(np.ceil(distance / table.cell * (1 + margins.slack(1)))))
        begin, end = self.borders(self.last_shell)
        too_coarse = margins.slack(self.last_shell, record.stretch) > margins.RADIUS / 2
        if too_coarse or end - begin > NEVER or begin >> BEGIN_BITS:
            raise InputError(f"frustum: {self.last_shell} shells of {record.stretch:.6g} cells along the way of a grid "
                             "ray are too many; take a narrower view or larger cells")

    def rays(self, shell: int):
        """The frustum's `GridRays` of a shell."""
        record = self.record
        if record.is_screen:
            return screen_rays(shell, (record.columns, record.rows), (record.column_bits, record.row_bits),
                               record.half_angles)
        return hemisphere_rays(shell, record.columns, record.rows)

    def borders(self, shell: int) -> tuple[int, int]:
        """Where a shell begins and ends: parameters of grid rays in units of 2^-PLACE_FRACTION cells."""
        cell = self.record.stretch * (1 << PLACE_FRACTION)
        return int(np.rint((shell - 1) * cell)), int(np.rint(shell * cell))

    def settled(self, shell: int) -> float:
        """Hits at this distance and nearer, in R units of 1, cannot change any more from this shell on."""
        reach = max(0.0, shell - 1 - margins.depth(shell))
        cube = 2.0**self.record.numbers.scene_bits
        return reach * self.table.cell / cube * self.record.z_scale / 2.0**self.record.numbers.direction_fraction

    def limit(self, shell: int, config: Config) -> int:
        """A ray may still change from this shell on while its stored inverse distance is at most this: that of a hit as
        far as `settled`, rounded up.
        """
        distance, numbers = self.settled(shell), config.numbers
        if not distance > 0:
            return numbers.inverse.high
        mantissa, exponent = np.frexp(1 / distance)
        return int(encode(np.array(int(np.ceil(mantissa * 2.0**30))), np.array(int(exponent) - 30), numbers, up=True))

    def threshold(self, shell: int, config: Config) -> int:
        """`limit` for settle codes: a ray may still change while its code is below this."""
        return int(settle_threshold(np.array(self.limit(shell, config)), config))

    def open(self, shell: int, seen: np.ndarray | SettlePyramid, window=None, *, subshell: int = 0,
             threshold: int | None = None) -> np.ndarray:
        """Cells of one subshell, in the order in which they are met and as often as they are met.

        Each grid ray is looked at once: it goes through its shell, or it is found to have settled. In which order is
        free, since a ray that may still change is never taken for settled.

        Parameters
        ----------
        seen
            rows x columns bool of the frustum's rays: may the ray's hit still change, see `settled`? Or the pyramid of
            the sector's settle codes, and then its ``threshold``.
        window
            Of the subshell, see `subshell_rays`. Default: the last subshell, all of the sector.
        subshell
            Its number.
        """
        if shell == 1:
            return near_cells(self.record, self.table, self.record.slopes)
        rays = self.rays(shell)
        if shell not in self._memories:
            self._memories[shell] = RayMemory(rays.rows * rays.columns, deferred=0)
        memory = self._memories[shell]
        inside = sector_rays(rays, self.sector, self.record)
        if window is not None:
            inside &= subshell_rays(rays, window, self.record)
        asked = np.flatnonzero(inside)
        self.looked_at += len(asked)
        leaving, _ = memory.request(asked, subshell=subshell, shell=shell)
        if not len(leaving):
            return leaving
        going = survivors(rays, seen & self._own) if threshold is None else survivors_by_code(
            rays, seen, threshold, self.sector, self.record)
        cells = self._walk(rays, leaving[going.ravel()[leaving]])
        memory.complete(leaving)
        return cells

    def _walk(self, rays, numbers):
        """Cells of some grid rays, pass by pass."""
        direction = global_directions(rays.direction.reshape(-1, 3)[numbers], self.record)
        begin, end = self.borders(rays.shell)
        walk = Traversal(self._place, direction, begin=begin, end=end, shape=self.table.shape)
        self.grid_rays += len(direction)
        self.turns += len(direction) - len(walk.ray)
        cells = []
        while len(walk.ray):
            cells.append(self.table.number(walk.index[walk.inside]))
            self.steps += len(cells[-1])
            self.turns += len(walk.ray)
            walk.advance()
        return np.concatenate(cells) if cells else np.empty(0, dtype=np.int64)


def global_directions(directions: np.ndarray, record: FrustumRecord) -> np.ndarray:
    """K x 3 int64 `GridRays` directions in G, units of 2^-FRACTION, below 4 in magnitude."""
    return round_shift(directions @ record.to_global.T, record.numbers.direction_fraction)
