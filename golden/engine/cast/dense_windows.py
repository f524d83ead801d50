"""Parts of a hemisphere cast again with twice the azimuths and polar angles, where few rays meet a patch."""

from collections.abc import Generator

import numpy as np

from golden.cast.density import Density, Level
from golden.cast.hemisphere import Hemisphere
from golden.engine.config import Config
from golden.engine.icu.g2r_transform import g2r_transform
from golden.engine.icu.inverse_distance import inverse_distance
from golden.engine.icu.patch_setup import PatchSetup
from golden.engine.icu.ray_memory import RayMemory
from golden.engine.icu.sbb import SphericalWindows
from golden.engine.icu.screening import cones
from golden.engine.icu.vertex_direction import vertex_direction
from golden.engine.scene.patch_geometry import PatchGeometry

__all__ = ["DenseWindows"]

# A patch of whose window's cells there are so many times the rays that should meet it is hidden, or a sliver.
_HIDDEN = 4
# Pairs of rays and patches per block, which bounds memory.
_PAIRS = 1 << 20


class DenseWindows:
    """The finer rays of one hemisphere, in the machine's integers, with the hits of sections of finer hemispheres.

    Parameters
    ----------
    density, hemisphere
        Where rays are cast again, and the coarse grid.
    record
        Function from a level to the `FrustumRecord` of the hemisphere of that level's grid.
    geometry, config
        The patches, and the configuration.
    """

    def __init__(self, density: Density, hemisphere: Hemisphere, record, geometry: PatchGeometry, config: Config):
        self.record, self._density, self._hemisphere, self._config = record, density, hemisphere, config
        self._depth = density.depth(hemisphere)
        # Planes are those of all grids, and windows of the finest grid those of all others, with a shift.
        coarse = record(0)
        self._patches = PatchSetup(coarse, config).patches(geometry)
        directions, _ = vertex_direction(g2r_transform(coarse, geometry.vertices), config.numbers)
        self._window = SphericalWindows(record(self._depth), config).windows(directions, self._patches.planes).only(
            self._patches.live)
        owner, planes = cones(self._patches.planes)
        order = np.argsort(owner, kind="stable")
        self._planes, self._first = planes[order], np.searchsorted(owner[order], np.arange(len(geometry) + 1))

    def cast(self, patch: np.ndarray) -> Generator[
            tuple[int, np.ndarray, np.ndarray], np.ndarray, list[tuple[Level, np.ndarray, np.ndarray, np.ndarray]]]:
        """The rays that replace those of the coarse grid, whose patches are ``patch``.

        It yields, level by level from 1 on, the level's number and columns and rows of rays, and is sent the patches
        that they meet, as `nearest` finds them.

        Returns
        -------
        For each level from 0 on the level, and columns, rows and patches of the rays whose cells stay undivided.
        """
        level = Level(self._hemisphere, 0)
        row, column = np.divmod(np.arange(len(self._hemisphere)), self._hemisphere.azimuths)
        small = self._window.rays > 0
        leaves = []
        for number in range(self._depth + 1):
            small = small & (np.bincount(patch[patch >= 0], minlength=len(small)) < self._density.least)
            divided = self._touched(np.flatnonzero(small), number, column, row) if number < self._depth else \
                np.zeros(len(column), dtype=bool)
            stays = ~divided
            leaves.append((level, column[stays], row[stays], patch[stays]))
            if not divided.any():
                break
            level = Level(self._hemisphere, number + 1)
            column, row = (np.concatenate([2 * values[divided] + offset for offset in offsets]) for values, offsets in (
                (column, (0, 1, 0, 1)), (row, (0, 0, 1, 1))))
            patch = yield number + 1, column, row
        return leaves

    def _touched(self, patches, level, column, row):
        """Which cells of a level the windows of these patches meet, unless they show that a patch is hidden."""
        span = self._spans(patches, level)
        seen = span[1] * span[3] < _HIDDEN * self._density.least
        result = np.zeros(len(column), dtype=bool)
        for first, columns, low, rows in np.stack(span)[:, seen].T:
            result |= ((column - first) % (self._hemisphere.azimuths << level) < columns) & (row >= low) & (
                row < low + rows)
        return result

    def _spans(self, patches, level):
        """First column, columns, first row and rows of windows in cells of a level."""
        window, shift = self._window[patches], self._depth - level
        first, low = window.column_first >> shift, window.row_first >> shift
        last, high = window.column_first + window.column_count - 1, window.row_first + window.row_count - 1
        most = self._hemisphere.azimuths << level
        return first, np.minimum((last >> shift) - first + 1, most), low, (high >> shift) - low + 1

    def nearest(self, level: int, column: np.ndarray, row: np.ndarray) -> np.ndarray:
        """The patch that each of K rays of a level meets, or -1: K int64."""
        record, memory = self.record(level), RayMemory(len(column), self._config)
        directions = record.directions(column, row)
        live = np.flatnonzero(self._window.rays > 0)
        first, columns, low, rows = (span[:, None] for span in self._spans(live, level))
        step = max(1, _PAIRS // max(1, len(live)))
        for start in range(0, len(column), step):
            c, r = column[start:start + step], row[start:start + step]
            which, ray = np.nonzero(((c - first) % record.columns < columns) & (r >= low) & (r < low + rows))
            patch, ray = live[which], ray + start
            hit = self._inside(self._first[patch], directions[ray])
            two = np.flatnonzero(self._first[patch + 1] - self._first[patch] > 1)
            hit[two] |= self._inside(self._first[patch[two]] + 1, directions[ray[two]])
            patch, ray = patch[hit], ray[hit]
            memory.update(ray, inverse_distance(self._patches.factor[patch], directions[ray], self._config.numbers),
                          patch)
        return memory.patch

    def _inside(self, cone, direction):
        return (np.einsum("kei,ki->ke", self._planes[cone], direction) >= 0).all(axis=1)
