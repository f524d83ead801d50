"""Embree, through trimesh, on our patches: a third party's nearest hits."""

import numpy as np
import trimesh

from golden.cast.rays import Rays
from golden.scene.scene import Scene

__all__ = ["Embree"]


class Embree:
    """Casts in single precision over two triangles per quadrilateral.

    Parameters
    ----------
    scene
        The patches.
    """

    def __init__(self, scene: Scene):
        second = np.flatnonzero(~scene.is_triangle)
        triangles = np.concatenate([scene.vertices[:, :3], scene.vertices[second][:, [0, 2, 3]]])
        self._patch = np.append(np.concatenate([np.arange(len(scene)), second]), -1)
        mesh = trimesh.Trimesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), process=False)
        self._intersector = trimesh.ray.ray_pyembree.RayMeshIntersector(mesh)

    def nearest(self, rays: Rays) -> np.ndarray:
        """The patch that each ray meets first, or -1."""
        return self._patch[self._intersector.intersects_first(rays.origin, rays.direction)]
