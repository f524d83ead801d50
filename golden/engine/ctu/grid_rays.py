"""The sparse grid rays of each shell, and the intersection rays that each of them represents.

*Density*: every cell whose centre is in shell s is met, within shell s, by a grid ray of shell s.

Source: docs/exactness.md, Shelling; Shen 1993, Eq. 3.1, with the nearest grid ray measured to the cell's centre, which
saves an eighth of the rays.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from golden.engine.ctu import margins
from golden.engine.frustum.record import screen_slope_scale
from golden.engine.lib.fixed import round_shift

__all__ = ["FRACTION", "INDEX_FRACTION", "KEPT", "GridRays", "hemisphere_rays", "screen_rays", "steps"]

# Fraction bits of the direction tables, and of positions among the intersection rays.
FRACTION = 16
INDEX_FRACTION = 8

KEPT = 128
"""Shells whose grid rays are kept in memory."""


@dataclass(frozen=True, kw_only=True, eq=False)
class GridRays:
    """Grid rays of one shell, ``rows`` x ``columns``, in row-major order.

    The intersection rays near grid ray (k, l) are the ``row_count[k]`` rows from ``first_row[k]`` and, in each, the
    ``column_count[k, l]`` columns from ``first_column[k, l]``; in a hemisphere columns wrap around the circle.

    Members
    -------
    shell
        Number of the shell, at least 2: the cells of shell 1 are opened without grid rays.
    direction
        rows x columns x 3 int64 in units of 2^-FRACTION, below 2: of unit length in the frustum's R frame (hemisphere),
        or slopes to the right and down divided by `FrustumRecord.slope_scale`, and 1 (screen).
    first_row, row_count
        ``rows`` int64.
    first_column, column_count
        rows x columns int64.
    row_position, column_position
        ``rows`` and ``columns`` int64: positions of the grid rays among the intersection rays, in units of
        2^-INDEX_FRACTION of their rows and columns; ray number j covers j to j + 1.
    row_border, column_border
        Margin of a sector's grid rays beyond its border, in the same units: a number, and ``rows`` int64.
    row_table, column_table
        Tables of `direction`. Hemisphere: ``rows`` x 2, sin and cos of the polar angle, and ``columns`` x 2, cos and
        sin of the azimuth. Screen: ``rows`` x 1 and ``columns`` x 1, scaled slopes.
    column_reach
        ``rows`` int64: a column of intersection rays is near if its middle is at most this far from the grid ray's
        position; `first_column` and `column_count` follow from it.
    """

    shell: int
    direction: np.ndarray
    first_row: np.ndarray
    row_count: np.ndarray
    first_column: np.ndarray
    column_count: np.ndarray
    row_position: np.ndarray
    column_position: np.ndarray
    row_border: int
    column_border: np.ndarray
    row_table: np.ndarray
    column_table: np.ndarray
    column_reach: np.ndarray

    @property
    def rows(self) -> int:
        """Number of rows, each of one polar angle or one y."""
        return self.direction.shape[0]

    @property
    def columns(self) -> int:
        """Number of columns, each of one azimuth or one x."""
        return self.direction.shape[1]


def steps(shell: int, rounding: tuple[float, float] = margins.DEFAULT):
    """Largest azimuth step and polar step of a hemisphere's grid rays of a shell, in radians."""
    covered = margins.RADIUS - margins.slack(shell, rounding=rounding)
    r = np.tan(2 * np.arcsin(covered / (2 * shell)))
    return 2 * np.arctan(r / np.sqrt(2)), 2 * np.arctan(r / np.sqrt(2 + r * r))


@lru_cache(maxsize=KEPT)
def hemisphere_rays(shell: int, azimuths: int, polars: int,
                    rounding: tuple[float, float] = margins.DEFAULT) -> GridRays:
    """Grid rays of a shell for a hemisphere of ``azimuths`` x ``polars`` intersection rays; `margins.rounding`.

    Row k has the polar angle ``(k + 1/2)`` polar steps, column k the azimuth ``(k + 1/2)`` azimuth steps. Rows extend
    below the horizon as far as a cell that holds a hit above it may have its centre (`margins.horizon`).
    """
    azimuth_step, polar_step = steps(shell, rounding)
    lowest = np.pi / 2 + margins.horizon(shell, rounding)
    columns, rows = int(np.ceil(2 * np.pi / azimuth_step)), int(np.ceil(lowest / polar_step))
    azimuth = (np.arange(columns) + 0.5) * (2 * np.pi / columns)
    polar = (np.arange(rows) + 0.5) * (lowest / rows)
    around = np.stack([_table(np.cos(azimuth)), _table(np.sin(azimuth))], axis=1)
    down = np.stack([_table(np.sin(polar)), _table(np.cos(polar))], axis=1)
    direction = np.empty((rows, columns, 3), dtype=np.int64)
    direction[..., :2] = round_shift(down[:, None, :1] * around, FRACTION)
    direction[..., 2] = down[:, None, 1]

    per_polar, per_azimuth = polars / (np.pi / 2), azimuths / (2 * np.pi)
    row_position, column_position = _position(polar * per_polar), _position(azimuth * per_azimuth)
    psi, border = margins.angle(shell, rounding), margins.sector_angle(shell, rounding)
    first_row, row_count = _window(row_position, _reach(psi * per_polar), polars)
    reach = _reach(margins.azimuth_reach(psi, polar) * per_azimuth)
    first, last = _span(column_position, reach[:, None])
    count = np.clip(last - first + 1, 0, azimuths)
    first = np.where(count == azimuths, 0, first % azimuths)
    return GridRays(shell=shell, direction=direction, first_row=first_row, row_count=row_count, first_column=first,
                    column_count=count, row_position=row_position, column_position=column_position,
                    row_border=int(_reach(border * per_polar)),
                    column_border=_reach(margins.sector_reach(border, polar) * per_azimuth), row_table=down,
                    column_table=around, column_reach=reach)


@lru_cache(maxsize=KEPT)
def screen_rays(shell: int, pixels: tuple[int, int], bits: tuple[int, int], half_angles: tuple[float, float],
                spread: float = 0, rounding: tuple[float, float] = margins.DEFAULT) -> GridRays:
    """Grid rays of a shell (a slab of depth) for a screen.

    Parameters
    ----------
    pixels
        Columns and rows of the screen.
    bits, half_angles
        The full grid: ``2^bits`` columns (rows) over the slopes ``-half_angles`` to ``half_angles``; the pixels are its
        middle.
    spread
        Largest distance of a ray from the middle of its column and row, in columns and rows.
    rounding
        `margins.rounding`.
    """
    halves = [angle * count / 2.0**bit for count, bit, angle in zip(pixels, bits, half_angles, strict=True)]
    slope_scale, axes = screen_slope_scale(halves), []
    step = 2 * (margins.RADIUS - margins.slack(shell, slope_scale, rounding)) / (np.sqrt(2) * shell)
    for count, half in zip(pixels, halves, strict=True):
        scale = count / (2 * half)
        border = margins.screen_border(shell, half, slope_scale, rounding)
        rays = int(np.ceil(2 * (half + border) / step))
        slope = ((2 * np.arange(rays) + 1) / rays - 1) * (half + border)
        position = _position((slope + half) * scale)
        reach = _reach(margins.screen_reach(shell, half, step, slope_scale, rounding) * scale + spread)
        border = int(_reach(margins.screen_sector_reach(shell, half, step, slope_scale, rounding) * scale))
        axes.append((_table(slope / slope_scale), position, border, reach, *_window(position, reach, count)))
    (x, column_position, column_border, column_reach, first_column, column_count), (
        y, row_position, row_border, _, first_row, row_count) = axes
    across = (len(y), len(x))
    direction = np.empty((*across, 3), dtype=np.int64)
    direction[..., 0], direction[..., 1], direction[..., 2] = x, y[:, None], 1 << FRACTION
    return GridRays(shell=shell, direction=direction, first_row=first_row, row_count=row_count,
                    first_column=np.broadcast_to(first_column, across),
                    column_count=np.broadcast_to(column_count, across), row_position=row_position,
                    column_position=column_position, row_border=row_border,
                    column_border=np.full(len(y), column_border), row_table=y[:, None], column_table=x[:, None],
                    column_reach=np.full(len(y), column_reach))


def _table(values):
    return np.rint(values * (1 << FRACTION)).astype(np.int64)


def _position(index):
    return np.floor(index * (1 << INDEX_FRACTION)).astype(np.int64)


def _reach(index):
    """A reach rounded up, plus one unit since positions are truncated."""
    return np.ceil(np.asarray(index) * (1 << INDEX_FRACTION)).astype(np.int64) + 1


def _span(position, reach):
    """First and last of the rays j whose middle, j + 1/2, is within ``reach`` of a position."""
    half = 1 << INDEX_FRACTION - 1
    return -((reach + half - position) >> INDEX_FRACTION), (position + reach - half) >> INDEX_FRACTION


def _window(position, reach, count):
    """`_span` clipped to 0 ... count - 1, as first ray and number of rays."""
    first, last = _span(position, reach)
    first, last = np.maximum(first, 0), np.minimum(last, count - 1)
    return np.minimum(first, count), np.maximum(last - first + 1, 0)
