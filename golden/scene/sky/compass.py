"""East, north and zenith of a scene."""

import numpy as np

from golden.base.errors import InputError

__all__ = ["compass"]


def compass(up, north=None) -> np.ndarray:
    """The unit vectors to the east, to the north and to the zenith as the rows of a 3 x 3 matrix.

    Parameters
    ----------
    up
        The scene's up, of any length above 0.
    north
        Direction of the north; its part along the up is left out. Default: +y if up is +z, -z if up is +y.

    Raises
    ------
    InputError
        The north is zero, not finite or along the up.
    """
    zenith = np.array(up, dtype=np.float64) / np.linalg.norm(up)
    level = np.array(((0, 0, -1) if abs(zenith[1]) > abs(zenith[2]) else (0, 1, 0)) if north is None else north)
    level = level - (level @ zenith) * zenith
    length = np.linalg.norm(level)
    if not (np.isfinite(length) and length > 1e-9):
        raise InputError(f"daylight: North must not be zero or along the scene's up, not {north!r}", parameter="north")
    level = level / length
    return np.stack([np.cross(level, zenith), level, zenith])
