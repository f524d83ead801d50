"""Local axes for normals."""

import numpy as np

__all__ = ["frame"]

# The normal from whose frame all others are rotated. It is oblique, so that the one discontinuity of the frames is far
# from the normals of buildings.
_POLE = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
_AXIS_0 = np.array([2.0, -1.0, 0.0]) / np.sqrt(5.0)
_AXIS_90 = np.cross(_POLE, _AXIS_0)


def frame(normals) -> np.ndarray:
    """Local axes for unit normals.

    The shortest rotation from an oblique pole to the normal rotates the pole's axes too. So equal normals have equal
    frames, and near normals near frames, except across a circle of 26 degrees around the opposite of the pole.

    Parameters
    ----------
    normals
        M x 3 unit vectors (or one vector of 3).

    Returns
    -------
    M x 3 x 3 float64 (or 3 x 3): rows are the axes of azimuth 0 and 90 degrees, and the normal; right-handed.
    A local direction ``d`` is ``d @ frame`` in the scene.
    """
    normals = np.asarray(normals, dtype=np.float64)
    cosine = normals @ _POLE
    # Near the opposite of the pole the shortest rotation is ill-defined: it starts from the pole reversed there.
    side = np.where(cosine < -0.9, -1.0, 1.0)
    start = np.stack(np.broadcast_arrays(_AXIS_0, side[..., None] * _AXIS_90), axis=-2)
    middle = side[..., None] * _POLE + normals
    along = np.einsum("...ij,...j->...i", start, normals) / (1.0 + side * cosine)[..., None]
    return np.concatenate([start - along[..., None] * middle[..., None, :], normals[..., None, :]], axis=-2)
