"""The sides of patches between which view factors are computed."""

import numpy as np

from golden.cast.frame import frame
from golden.scene.scene import Scene

__all__ = ["Sides"]


class Sides:
    """The fronts of a scene's patches, then the backs of its two-sided ones: N in all.

    Members
    -------
    scene
        The patches.
    patch, front
        N int64 and N bool: the patch of each side, and whether it is its front.
    vertices
        N x 4 x 3, counter-clockwise seen from the side; a triangle repeats its last vertex.
    normal, area, surface
        N x 3 unit normals out of the side, N float64, and N int32 (see `Scene`).
    triangle
        N bool: whether the patch is a triangle.
    axes
        N x 3 x 3, the `frame` of each normal.
    centre, radius
        N x 3 and N float64: the smallest ball around the mean of the corners that contains the patch.
    """

    def __init__(self, scene: Scene):
        backs = np.flatnonzero(scene.two_sided)
        self.scene = scene
        self.patch = np.concatenate([np.arange(len(scene)), backs])
        self.front = np.arange(len(self.patch)) < len(scene)
        self._back = np.full(len(scene), -1)
        self._back[backs] = len(scene) + np.arange(len(backs))
        # Reversed such that a triangle's repeated vertex stays last.
        turned = np.where(scene.is_triangle[backs, None], [1, 0, 2, 3], [3, 2, 1, 0])
        self.vertices = np.concatenate([
            scene.vertices, np.take_along_axis(scene.vertices[backs], turned[..., None], axis=1)])
        self.normal = np.concatenate([scene.normals, -scene.normals[backs]])
        self.axes = frame(self.normal)
        self.area = scene.areas[self.patch]
        self.surface = scene.surface[self.patch]
        self.triangle = scene.is_triangle[self.patch]
        self.centre = scene.centres[self.patch]
        self.radius = np.linalg.norm(self.vertices - self.centre[:, None], axis=2).max(axis=1)

    def __len__(self) -> int:
        return len(self.patch)

    def met(self, patch: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """The side that rays meet on the patches that they hit, or -1 on the back of a one-sided patch."""
        cosine = np.einsum("ri,ri->r", direction, self.scene.normals[patch])
        return np.where(cosine < 0, patch, self._back[patch])
