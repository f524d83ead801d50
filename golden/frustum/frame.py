"""Local axes for normals."""

import numpy as np

__all__ = ["frame"]

# The normal whose frame is the starting point of all others: oblique, so that the frames' one discontinuity stays away
# from the normals that buildings have.
_POLE = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
_AXIS_0 = np.array([2.0, -1.0, 0.0]) / np.sqrt(5.0)
_AXIS_90 = np.cross(_POLE, _AXIS_0)


def frame(normals) -> np.ndarray:
    """Local axes for unit normals.

    The rotation that takes an oblique pole to the normal the short way carries the pole's axes along, so equal normals
    have equal frames, and near normals near frames but for a circle of normals 26 degrees around the pole's opposite.

    Parameters
    ----------
    normals
        M x 3 unit vectors (or one vector of 3).

    Returns
    -------
    M x 3 x 3 (or 3 x 3): rows are the axis of azimuth 0, the axis of azimuth 90 degrees, and the normal; right-handed.
    A local direction ``d`` is ``d @ frame`` in the scene.
    """
    normals = np.asarray(normals, dtype=np.float64)
    cosine = normals @ _POLE
    # Near the pole's opposite the short way is ill-defined: start there from the pole turned over about axis 0.
    side = np.where(cosine < -0.9, -1.0, 1.0)
    start = np.stack(np.broadcast_arrays(_AXIS_0, side[..., None] * _AXIS_90), axis=-2)
    middle = side[..., None] * _POLE + normals
    along = np.einsum("...ij,...j->...i", start, normals) / (1.0 + side * cosine)[..., None]
    return np.concatenate([start - along[..., None] * middle[..., None, :], normals[..., None, :]], axis=-2)
