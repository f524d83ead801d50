"""The cell traversal unit of one cluster: the cells that it opens in each shell."""

import numpy as np

from golden.base.errors import InputError
from golden.engine.config import Config
from golden.engine.ctu import margins
from golden.engine.ctu.cell_traversal import BEGIN_BITS, NEVER, POSITION_FRACTION, Traversal
from golden.engine.ctu.grid_rays import KEPT, hemisphere_rays, screen_rays
from golden.engine.ctu.near_cells import near_cells
from golden.engine.ctu.ray_memory import RayMemory
from golden.engine.ctu.sector import Sector, sector_rays, subshell_rays
from golden.engine.ctu.settle_pyramid import SettlePyramid
from golden.engine.ctu.survival import survivors, survivors_by_code
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.inverse_distance import encode
from golden.engine.icu.settle_code import settle_threshold
from golden.engine.lib.fixed import round_shift
from golden.engine.memsys.patches.cell_table import CellTable

__all__ = ["CellTraversalUnit", "global_directions"]

# Bytes of a grid ray, of which a shell has as many as its number squared, times those of this one by its own; and most
# bytes of the shells kept between an origin and the scene.
RAY_BYTES, SAMPLE, MOST_BYTES = 40, 16, 8 << 30


class CellTraversalUnit:
    """Opens the cells of one frustum's sector, shell by shell.

    Parameters
    ----------
    record
        The frustum.
    table
        The cells.
    sector
        The cluster's part of the frustum. Default: all of it.

    Members
    -------
    last_shell
        The last shell that can hold the centre of a cell.
    rounding
        `margins.rounding` of the record's formats.
    scanned, grid_rays, steps, passes
        Counts: grid rays scanned, grid rays issued, cells that they visited, and traversal passes. Steps outside the
        grid are passes too; a ray that never enters the grid takes one pass.

    Raises
    ------
    InputError
        Directions are too coarse for the cells, or parameters exceed their bits: the field of view is too wide, or the
        cells are too small. Or the origin is so far from the scene that the grid rays of the shells between need more
        than 8 GiB.
    """

    def __init__(self, record: FrustumRecord, table: CellTable, sector: Sector | None = None):
        self.record, self.table = record, table
        self.sector = sector or Sector.whole(record)
        self._own = self.sector.mask(record)
        self._position = table.position(record.origin)
        self.scanned = self.grid_rays = self.steps = self.passes = 0
        self._memories: dict[int, RayMemory] = {}
        corners = np.array(np.meshgrid(*np.stack([table.lower, table.lower + table.cell * table.shape], axis=1)))
        offset = corners.reshape(3, -1).T - record.origin
        self.rounding = margins.rounding(record.numbers, self._displacement())
        if record.is_screen:
            distance = record.view_coordinates(offset)[:, 2].max()
        else:
            distance = np.sqrt((offset * offset).sum(axis=1).max())
        self.last_shell = max(1, int(np.ceil(distance / table.cell * (
            1 + margins.slack(1, rounding=self.rounding)))))
        begin, end = self.borders(self.last_shell)
        too_coarse = margins.slack(self.last_shell, record.slope_scale, self.rounding) > margins.RADIUS / 2
        if too_coarse or end - begin > NEVER or begin >> BEGIN_BITS:
            raise InputError(f"frustum: {self.last_shell} shells of {record.slope_scale:.6g} cells along a grid ray "
                             "are too many; use a narrower view or larger cells")
        self._check_memory(offset)

    def _displacement(self):
        """Of a vertex by the rounding of the R frame, in cells, if the table's margin does not cover it."""
        record, numbers = self.record, self.record.numbers
        slopes = np.array([*record.half_angles, 1.0] if record.is_screen else [1.0] * 3)
        units = np.linalg.norm(slopes) / min(1, slopes.min()) * 2.0**(numbers.scene_bits - numbers.vector_fraction - 1)
        return units / self.table.cell if units > self.table.margin else 0.0

    def _check_memory(self, offset):
        """Refuse an origin from which no ray can settle in so many shells that memory cannot hold their grid rays.

        ``offset`` leads to the corners of the cells.
        """
        if self.record.is_screen:
            distance = self.record.view_coordinates(offset)[:, 2].min()
        else:
            distance = np.linalg.norm(np.maximum(np.maximum(offset.min(axis=0), -offset.max(axis=0)), 0))
        shells = int(max(distance, 0) / self.table.cell)
        if shells <= SAMPLE:
            return
        sample = self.rays(SAMPLE)
        size = RAY_BYTES * sample.rows * sample.columns * (shells / SAMPLE)**2 * min(shells, KEPT)
        if size > MOST_BYTES:
            raise InputError(f"frustum: {shells} shells lie between its origin and the scene, whose grid rays need "
                             f"{size / 2**30:.0f} GiB, more with the square of their number, and at most "
                             f"{MOST_BYTES >> 30} are allowed; use larger cells or a nearer origin, or --method embree")

    def rays(self, shell: int):
        """The frustum's `GridRays` of a shell."""
        record = self.record
        if record.is_screen:
            return screen_rays(shell, (record.columns, record.rows), (record.column_bits, record.row_bits),
                               record.half_angles, 0.5 if record.spread else 0, self.rounding)
        return hemisphere_rays(shell, record.columns, record.rows, self.rounding)

    def borders(self, shell: int) -> tuple[int, int]:
        """Begin and end of a shell: parameters of grid rays in units of 2^-POSITION_FRACTION cells."""
        cell = self.record.slope_scale * (1 << POSITION_FRACTION)
        return int(np.rint((shell - 1) * cell)), int(np.rint(shell * cell))

    def settled(self, shell: int) -> float:
        """Largest distance of a hit, in R units of 1, that no patch of this or a later shell can improve."""
        reach = max(0.0, shell - 1 - margins.depth(shell, self.rounding))
        cube = 2.0**self.record.numbers.scene_bits
        return reach * self.table.cell / cube * self.record.least_z_scale / 2.0**self.record.numbers.direction_fraction

    def limit(self, shell: int, config: Config) -> int:
        """Largest stored inverse distance of a ray that may still change from this shell on.

        It is the inverse distance of a hit as far as `settled`, rounded up.
        """
        distance, numbers = self.settled(shell), config.numbers
        if not distance > 0:
            return numbers.inverse.high
        mantissa, exponent = np.frexp(1 / distance)
        return int(encode(np.array(int(np.ceil(mantissa * 2.0**30))), np.array(int(exponent) - 30), numbers, up=True))

    def threshold(self, shell: int, config: Config) -> int:
        """`limit` for settle codes: a ray whose code is below it may still change."""
        return int(settle_threshold(np.array(self.limit(shell, config)), config))

    def open(self, shell: int, seen: np.ndarray | SettlePyramid, window=None, *, subshell: int = 0,
             threshold: int | None = None) -> np.ndarray:
        """Cells of one subshell in the order in which grid rays meet them, with repetitions.

        Each grid ray is scanned once: it traverses its shell, or it is settled. The order of the scan does not matter,
        since a ray that may still change never counts as settled.

        Parameters
        ----------
        seen
            rows x columns bool of the frustum's rays: the ray may still change, see `settled`. Or the settle pyramid of
            the sector, together with ``threshold``.
        window
            Window of the subshell, see `subshell_rays`. Default: the last subshell, the whole sector.
        subshell
            Number of the subshell.
        threshold
            Threshold of the shell for settle codes.
        """
        if shell == 1:
            return near_cells(self.record, self.table, self.record.slopes, self.rounding)
        rays = self.rays(shell)
        if shell not in self._memories:
            self._memories[shell] = RayMemory(rays.rows * rays.columns, deferred=0)
        memory = self._memories[shell]
        inside = sector_rays(rays, self.sector, self.record)
        if window is not None:
            inside &= subshell_rays(rays, window, self.record)
        requested = np.flatnonzero(inside)
        self.scanned += len(requested)
        issued, _ = memory.request(requested, subshell=subshell, shell=shell)
        if not len(issued):
            return issued
        alive = survivors(rays, seen & self._own) if threshold is None else survivors_by_code(
            rays, seen, threshold, self.sector, self.record)
        cells = self._traverse(rays, issued[alive.ravel()[issued]])
        memory.complete(issued)
        return cells

    def _traverse(self, rays, numbers):
        """Cells of some grid rays, pass by pass."""
        direction = global_directions(rays.direction.reshape(-1, 3)[numbers], self.record)
        begin, end = self.borders(rays.shell)
        traversal = Traversal(self._position, direction, begin=begin, end=end, shape=self.table.shape)
        self.grid_rays += len(direction)
        self.passes += len(direction) - len(traversal.ray)
        cells = []
        while len(traversal.ray):
            cells.append(self.table.number(traversal.index[traversal.inside]))
            self.steps += len(cells[-1])
            self.passes += len(traversal.ray)
            traversal.advance()
        return np.concatenate(cells) if cells else np.empty(0, dtype=np.int64)


def global_directions(directions: np.ndarray, record: FrustumRecord) -> np.ndarray:
    """K x 3 int64 `GridRays` directions in G, units of 2^-FRACTION, below 4 in magnitude."""
    return round_shift(directions @ record.to_global.T, record.numbers.direction_fraction)
