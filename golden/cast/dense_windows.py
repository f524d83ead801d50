"""Parts of a hemisphere cast again with twice the azimuths and polar angles, where few rays meet a patch."""

from dataclasses import dataclass
from numbers import Integral

import numpy as np

from golden.config import Config
from golden.errors import InputError
from golden.frustum import FrustumRecord, Hemisphere
from golden.icu.g2r_transform import g2r_transform
from golden.icu.inverse_distance import inverse_distance
from golden.icu.patch_setup import PatchSetup
from golden.icu.ray_memory import RayMemory
from golden.icu.sbb import SphericalWindows
from golden.icu.screening import cones
from golden.icu.vertex_direction import vertex_direction
from golden.scene.patch_geometry import PatchGeometry

__all__ = ["MOST_AXIS", "DenseWindows", "Density", "Level"]

MOST_AXIS = 4096
"""Azimuths, and polar angles, of the finest grid."""
# A patch of whose window's cells there are so many times the rays that should meet it is hidden, or a sliver.
_HIDDEN = 4
# Pairs of rays and patches per block, which bounds memory.
_PAIRS = 1 << 20


@dataclass(frozen=True, kw_only=True)
class Density:
    """Where rays are cast again.

    Parameters
    ----------
    least
        Rays that should meet a patch, 1 to 4096: the cells around one that fewer meet are cast again.
    levels
        Most times that a cell is, 1 to 10; no grid has more than `MOST_AXIS` azimuths or polar angles.

    Raises
    ------
    InputError
        A value is out of range.
    """

    least: int
    levels: int = 10

    def __post_init__(self):
        for name, most in (("least", 4096), ("levels", 10)):
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, Integral) or not 1 <= value <= most:
                raise InputError(f"density: {name.capitalize()} must be 1 to {most}, not {value!r}", parameter=name)

    def depth(self, hemisphere: Hemisphere) -> int:
        """Levels below those of a hemisphere's grid."""
        return min(self.levels, (MOST_AXIS // max(hemisphere.azimuths, hemisphere.polars)).bit_length() - 1)


@dataclass(frozen=True, eq=False)
class Level:
    """A grid with 2^``level`` times the azimuths and polar angles of a hemisphere, whose cells it divides.

    Its weights are in units of 2^-(W + level), W the hemisphere's ``weight_bits``: those of the four cells of a coarser
    cell sum to its own, exactly.
    """

    hemisphere: Hemisphere
    level: int

    @property
    def grid(self) -> Hemisphere:
        """The grid of rays, with weights of its own."""
        return Hemisphere(self.hemisphere.azimuths << self.level, self.hemisphere.polars << self.level)

    @property
    def row_weights(self) -> np.ndarray:
        """Int64: the weight of one ray of each row."""
        count = self.hemisphere.polars << self.level
        share = np.sin(np.arange(count + 1) * (np.pi / 2 / count)) ** 2
        return np.diff(np.rint(share * (2**self.hemisphere.weight_bits // self.hemisphere.azimuths)).astype(np.int64))

    def directions(self, column: np.ndarray, row: np.ndarray) -> np.ndarray:
        """K x 3 unit vectors in the local frame."""
        grid = self.grid
        polar, azimuth = (2 * row + 1) * (np.pi / 4 / grid.polars), (2 * column + 1) * (np.pi / grid.azimuths)
        return np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=1)


class DenseWindows:
    """The finer rays of one hemisphere, in the machine's integers, with the hits of sections of finer hemispheres.

    Parameters
    ----------
    density, hemisphere
        Where rays are cast again, and the coarse grid.
    record
        Function from a level to the hemisphere of that level's grid.
    geometry, config
        The patches, and the configuration.
    """

    def __init__(self, density: Density, hemisphere: Hemisphere, record, geometry: PatchGeometry, config: Config):
        self._density, self._hemisphere, self._record, self._config = density, hemisphere, record, config
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

    def cast(self, patch: np.ndarray) -> list[tuple[Level, np.ndarray, np.ndarray, np.ndarray]]:
        """The rays that replace those of the coarse grid, whose patches are ``patch``.

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
            patch = self._nearest(self._record(number + 1), number + 1, column, row)
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

    def _nearest(self, record: FrustumRecord, level, column, row):
        """The patch that each of K rays meets, or -1."""
        memory, directions = RayMemory(len(column), self._config), record.directions(column, row)
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
