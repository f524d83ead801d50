"""What some rows of view factors hold before both directions of each pair are joined."""

from dataclasses import dataclass

import numpy as np

__all__ = ["RowBlock"]


@dataclass(frozen=True, kw_only=True, eq=False)
class RowBlock:
    """What R consecutive sides see: E entries.

    Parameters
    ----------
    start
        R + 1 int64: row r has the entries ``start[r]`` to ``start[r + 1] - 1``, by increasing column.
    column
        E int32.
    hits
        E int32: rays of the row's hemisphere that met the column.
    factor, error
        E float64: the view factor from row to column and its standard error, 0 if it is exact; NaN where only
        rays measured it.
    rays, back
        R int64: rays of each row's hemisphere, and those that met the black back of a one-sided patch.
    sky, sky_error
        R float64: the share that leaves the scene, by these rays and maybe more, or by geometry (`exact_sky`), and its
        standard error.
    sky_patches
        R x P int32: of the rays that left those through each patch of the sky; P = 0 if they are not requested.
    sky_rays
        R int64: the rays that may have left, those of the hemisphere and maybe more.
    hidden_error
        R float64: the largest standard error of a factor that segments gave as 0 and that is no entry.
    """

    start: np.ndarray
    column: np.ndarray
    hits: np.ndarray
    factor: np.ndarray
    error: np.ndarray
    rays: np.ndarray
    sky: np.ndarray
    back: np.ndarray
    sky_error: np.ndarray
    sky_patches: np.ndarray
    sky_rays: np.ndarray
    hidden_error: np.ndarray

    def __getitem__(self, rows: slice) -> "RowBlock":
        """Consecutive rows."""
        first, last, _ = rows.indices(len(self.sky))
        entries = slice(self.start[first], self.start[last])
        parts = {name: getattr(self, name)[entries] for name in ("column", "hits", "factor", "error")}
        parts |= {name: getattr(self, name)[first:last]
                  for name in ("rays", "sky", "back", "sky_error", "sky_patches", "sky_rays", "hidden_error")}
        return RowBlock(start=self.start[first:last + 1] - self.start[first], **parts)
