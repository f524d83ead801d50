"""Survival: a grid ray survives while an intersection ray near it may still change.

Source: docs/exactness.md, Shelling.
"""

import numpy as np

from golden.engine.ctu.grid_rays import GridRays
from golden.engine.ctu.sector import Sector
from golden.engine.ctu.settle_pyramid import SettlePyramid
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.section_clip import section_clip
from golden.engine.icu.window import Window

__all__ = ["summed", "survivors", "survivors_by_code"]


def survivors(rays: GridRays, may_change: np.ndarray) -> np.ndarray:
    """Whether any intersection ray near a grid ray may still change.

    With outdated distances the result is a superset: distances only shrink.

    Parameters
    ----------
    rays
        Grid rays of the shell.
    may_change
        rows x columns bool of the frustum's intersection rays; False for other clusters' rays.

    Returns
    -------
    rows x columns bool of the grid rays.
    """
    if may_change.all():
        return (rays.row_count[:, None] > 0) & (rays.column_count > 0)
    width = may_change.shape[1]
    # Columns twice, so that a window may wrap past the end of a row.
    total = summed(np.concatenate([may_change, may_change], axis=1))
    top, bottom = rays.first_row[:, None], (rays.first_row + rays.row_count)[:, None]
    left, right = rays.first_column, rays.first_column + rays.column_count
    return _some(total, top, bottom, left, np.minimum(right, 2 * width))


def survivors_by_code(rays: GridRays, pyramid: SettlePyramid, threshold: int, section: Sector,
                      record: FrustumRecord) -> np.ndarray:
    """Survival as the machine computes it: a grid ray survives while a square that holds rays near it is live.

    Parameters
    ----------
    pyramid
        Settle pyramid of the section.
    threshold
        Threshold of the shell: a ray with a smaller code may still change.
    section
        The section of the frustum ``record``.

    Returns
    -------
    rows x columns bool of the grid rays: a superset of `survivors`.
    """
    near = Window(*(np.broadcast_to(value, rays.first_column.shape).ravel() for value in (
        rays.first_column, rays.column_count, rays.first_row[:, None], rays.row_count[:, None])))
    near = section_clip(near, section, record)
    total = summed(pyramid.live(threshold))
    rows = pyramid.touched(near.row_first, near.row_count)
    alive = _some(total, *rows, *pyramid.touched(near.column_first, near.column_count)) \
        | _some(total, *rows, *pyramid.touched(np.zeros_like(near.column_first), near.wrapped_count))
    return alive.reshape(rays.first_column.shape)


def summed(mask: np.ndarray) -> np.ndarray:
    """Summed-area table: counts above and to the left of each entry, rows + 1 x columns + 1."""
    total = np.zeros((mask.shape[0] + 1, mask.shape[1] + 1), dtype=np.int32)
    total[1:, 1:] = mask
    np.cumsum(total, axis=0, out=total)
    np.cumsum(total, axis=1, out=total)
    return total


def _some(total, top, bottom, left, right):
    """Whether the half-open ranges of rows and columns hold any."""
    return total[bottom, right] - total[top, right] > total[bottom, left] - total[top, left]
