"""Sample points on a scene's ceiling."""

import numpy as np

from golden.base.errors import InputError
from golden.engine.schedule.sections import grid_of
from golden.scene.scene import Scene

__all__ = ["ceiling_points"]

# Distance of the points below the ceiling, as a share of the scene's height, so that they are inside the scene.
BELOW = 1e-3


def ceiling_points(scene: Scene, count: int = 16) -> tuple[np.ndarray, np.ndarray]:
    """The centres of ``count`` equal parts of the upper side of the scene box, and the direction down.

    The ceiling is halved along its two axes alternately; the parts are numbered row by row.

    Parameters
    ----------
    count
        A power of two.

    Returns
    -------
    tuple
        M x 3 float64, points in scene units; and 3 float64, the direction.

    Raises
    ------
    InputError
        The count is no power of two, or the scene's up is along no axis.

    Source: Shen 1993, section 6.2; its numbering (Fig. 6.2) is lost.
    """
    if count < 1 or count & (count - 1):
        raise InputError(f"schedule: Points must be a power of two, not {count!r}")
    up = np.asarray(scene.up, dtype=np.float64)
    height = int(np.argmax(np.abs(up)))
    if np.count_nonzero(up) != 1:
        raise InputError(f"scene {scene.name!r}: a ceiling needs an up along an axis, not {scene.up!r}; "
                         "give an origin and a normal")
    columns, rows = grid_of(count)
    share = np.empty((count, 3))
    across, along = (axis for axis in range(3) if axis != height)
    share[:, across] = np.tile((np.arange(columns) + 0.5) / columns, rows)
    share[:, along] = np.repeat((np.arange(rows) + 0.5) / rows, columns)
    share[:, height] = 1 - BELOW if up[height] > 0 else BELOW
    lower, upper = scene.bounds
    return lower + share * (upper - lower), -np.sign(up)
