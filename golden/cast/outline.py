"""Outlines of patches: how narrow they are, and wider ones."""

import numpy as np

from golden.scene.scene import Scene

__all__ = ["narrowest", "widened"]

# Sine of the angle of a corner that counts as none.
_FLAT = 2.0**-40


def narrowest(scene: Scene) -> np.ndarray:
    """The least distance of a corner of each patch from an edge that does not end there, N float64."""
    heights = np.empty(len(scene))
    for rows, corners in _corners(scene):
        edge = np.roll(corners, -1, axis=1) - corners
        length = np.linalg.norm(edge, axis=2)
        across = [np.linalg.norm(np.cross(edge, np.roll(corners, -step, axis=1) - corners), axis=2)
                  for step in range(2, corners.shape[1])]
        with np.errstate(divide="ignore", invalid="ignore"):
            heights[rows] = np.nan_to_num(np.min(across, axis=0) / length, nan=0.0).min(axis=1)
    return heights


def widened(scene: Scene, width: float) -> np.ndarray:
    """Corners N x 4 x 3 of the patches with every edge moved outwards in the patch's plane.

    Parameters
    ----------
    scene
        The patches.
    width
        How far, in scene units. The tip of a needle moves farther, by at most the scene's size.
    """
    wide = np.empty_like(scene.vertices)
    for rows, corners in _corners(scene):
        after, before = (np.roll(corners, step, axis=1) - corners for step in (-1, 1))
        with np.errstate(divide="ignore", invalid="ignore"):
            after, before = (np.nan_to_num(edge / np.linalg.norm(edge, axis=2, keepdims=True))
                             for edge in (after, before))
        sine = np.linalg.norm(np.cross(after, before), axis=2, keepdims=True)
        outwards = -(after + before)
        # Straight on, away from the patch: to the right of the edge.
        beside = np.cross(after, scene.normals[rows][:, None])
        most = scene.size / width
        step = np.where(sine > _FLAT, outwards / np.maximum(sine, _FLAT),
                        np.where(np.einsum("pkj,pkj->pk", after, before)[..., None] < 0, beside, most * outwards))
        length = np.linalg.norm(step, axis=2, keepdims=True)
        moved = corners + width * step * np.minimum(1, most / np.maximum(length, 1))
        wide[rows] = moved if corners.shape[1] == 4 else moved[:, [0, 1, 2, 2]]
    return wide


def _corners(scene):
    """Numbers and corners of the triangles, and of the quadrilaterals."""
    for rows, count in ((np.flatnonzero(scene.is_triangle), 3), (np.flatnonzero(~scene.is_triangle), 4)):
        if len(rows):
            yield rows, scene.vertices[rows, :count]
