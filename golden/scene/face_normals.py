"""Normals of faces by the order of their corners, and those that a file states beside them."""

import numpy as np

__all__ = ["area_vectors", "contradicted"]


def area_vectors(points: np.ndarray, counts: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Twice the areas of F faces along their normals, F x 3.

    Parameters
    ----------
    points
        V x 3 float64, vertices.
    counts
        F int64, number of corners of each face, above 0.
    corners
        Vertex numbers of all faces, one face after the other, counter-clockwise as seen from the front.
    """
    starts = np.cumsum(counts) - counts
    local = points[corners] - np.repeat(points[corners[starts]], counts, axis=0)
    following = np.arange(1, len(local) + 1)
    following[starts + counts - 1] = starts
    return np.add.reduceat(np.cross(local, local[following]), starts, axis=0)


def contradicted(points: np.ndarray, counts: np.ndarray, corners: np.ndarray, normals: np.ndarray) -> int:
    """The number of faces whose stated normals are, in sum, opposite to the normal by the order of the corners.

    The order counts. Faces at vertices that do not exist are in no mesh (`golden.scene.mesh.check_mesh`).

    Parameters
    ----------
    points, counts, corners
        See `area_vectors`.
    normals
        C x 3, the normal at each corner; 0 or not finite where the file states none.
    """
    if not len(counts) or counts.min() < 1 or corners.min() < 0 or corners.max() >= len(points):
        return 0
    with np.errstate(invalid="ignore", over="ignore"):
        stated = np.add.reduceat(normals, np.cumsum(counts) - counts, axis=0)
        return int((np.einsum("fi,fi->f", area_vectors(points, counts, corners), stated) < 0).sum())
