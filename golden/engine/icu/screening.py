"""Screening: whether a ray is inside the edges of a patch. It is exact, and so watertight (docs/exactness.md)."""

import numpy as np

from golden.engine.config import Numbers
from golden.engine.icu.edge_planes import DIAGONAL, EdgePlanes

__all__ = ["cones", "edge_distances", "inside", "inside_cones"]


def edge_distances(planes: EdgePlanes, directions: np.ndarray, numbers: Numbers) -> np.ndarray:
    """n_ij . d of ray k with the planes of patch k: K x 6 int64, in the order of `EDGES`."""
    return numbers.edge_distance.check(np.einsum("kei,ki->ke", planes.planes, directions), "edge distance")


def inside(distances: np.ndarray, planes: EdgePlanes) -> tuple[np.ndarray, np.ndarray]:
    """Whether no distance has the sign opposite to the orientation, zero counting as inside.

    A split patch is its two triangles; the first takes precedence.

    Parameters
    ----------
    distances
        K x 6, see `edge_distances`.
    planes
        Edge planes of the same K patches.

    Returns
    -------
    tuple
        K bool: inside; and K int64: the orientation for which it is.
    """
    d01, d12, d23, d30, d02, _ = distances.T
    first, second = planes.orientation.T
    whole = _agree(first, d01, d12, d23, d30)
    one, two = _agree(first, d01, d12, -d02), _agree(second, d02, d23, d30)
    return np.where(planes.split, one | two, whole), np.where(planes.split & ~one, second, first)


def cones(planes: EdgePlanes) -> tuple[np.ndarray, np.ndarray]:
    """The planes of all that can be hit, oriented inwards.

    Returns
    -------
    tuple
        C patch numbers (a split patch twice), and C x 4 x 3 planes: a ray is inside a cone if none of the four has a
        negative product with it. A triangle of a split patch has one plane twice.
    """
    first, second = planes.orientation.T
    sets = ((~planes.split & (first != 0), first, [0, 1, 2, 3], 1),
            (planes.split & (first != 0), first, [0, 1, 1, DIAGONAL], -1),
            (planes.split & (second != 0), second, [3, 2, 2, DIAGONAL], 1))
    patches, inwards = [], []
    for which, orientation, edges, last in sets:
        patch = np.flatnonzero(which)
        oriented = planes.planes[patch][:, edges] * orientation[patch, None, None]
        oriented[:, 3] *= last
        patches.append(patch)
        inwards.append(oriented)
    return np.concatenate(patches), np.concatenate(inwards)


def inside_cones(planes: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All pairs of one of C `cones` and one of R directions (R x 3 int64) inside it: their numbers.

    The products are below 2^53, and so are all their partial sums: exact in float64, whose matrix product is fast.
    """
    product = planes.transpose(1, 0, 2).reshape(-1, 3).astype(np.float64) @ directions.T.astype(np.float64)
    product = product.reshape(4, len(planes), -1)
    least = np.minimum(product[0], product[1])
    np.minimum(least, product[2], out=least)
    np.minimum(least, product[3], out=least)
    return np.divmod(np.flatnonzero(least >= 0), product.shape[2])


def _agree(orientation, *distances):
    held = orientation != 0
    for distance in distances:
        held = held & (distance * orientation >= 0)
    return held
