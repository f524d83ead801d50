"""Which grid rays go on: those near an intersection ray whose hit may still change.

Source: design.md section 5.
"""

import numpy as np

from golden.ctu.grid_rays import GridRays

__all__ = ["survivors"]


def survivors(rays: GridRays, may_change: np.ndarray) -> np.ndarray:
    """Whether any intersection ray near a grid ray may still change.

    Judged on older distances it is never less: distances only shrink.

    Parameters
    ----------
    rays
        Grid rays of the shell.
    may_change
        rows x columns bool, of the bundle's intersection rays; of other clusters' rays False.

    Returns
    -------
    rows x columns bool of the grid rays.
    """
    if may_change.all():
        return (rays.row_count[:, None] > 0) & (rays.column_count > 0)
    height, width = may_change.shape
    # Sums over all rays above and to the left; twice around, so that a window may pass the end of a row.
    total = np.zeros((height + 1, 2 * width + 1), dtype=np.int32)
    total[1:, 1:width + 1] = may_change
    total[1:, width + 1:] = may_change
    np.cumsum(total, axis=0, out=total)
    np.cumsum(total, axis=1, out=total)
    top, bottom = rays.first_row[:, None], (rays.first_row + rays.row_count)[:, None]
    left, right = rays.first_column, rays.first_column + rays.column_count
    return total[bottom, right] - total[top, right] > total[bottom, left] - total[top, left]
