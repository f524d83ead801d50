"""Casting of rays by Mitsuba on a processor (``pip install -e .[reference]``): what it intersects with is Embree."""

import drjit as dr
import mitsuba as mi
import numpy as np

from golden.cast.rays import Rays
from golden.scene.scene import Scene

mi.set_variant("llvm_ad_rgb")

__all__ = ["MitsubaRays"]


class MitsubaRays:
    """All triangles of a scene as one mesh.

    Parameters
    ----------
    scene
        The scene; a quadrilateral is two triangles.
    """

    def __init__(self, scene: Scene):
        second = np.flatnonzero(~scene.is_triangle)
        triangles = np.concatenate([scene.vertices[:, :3], scene.vertices[second][:, [0, 2, 3]]])
        mesh = mi.Mesh("scene", vertex_count=3 * len(triangles), face_count=len(triangles), has_vertex_normals=False)
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = triangles.astype(np.float32).ravel()
        parameters["faces"] = np.arange(3 * len(triangles), dtype=np.uint32)
        parameters.update()
        self._world = mi.load_dict({"type": "scene", "mesh": mesh})
        self._patch = np.append(np.concatenate([np.arange(len(scene)), second]), -1).astype(np.int32)

    def nearest(self, rays: Rays) -> np.ndarray:
        """The patch that each ray hits first, R int32, or -1."""
        ray = mi.Ray3f(*(mi.Vector3f(np.ascontiguousarray(part.T, dtype=np.float32))
                         for part in (rays.origin, rays.direction)))
        found = self._world.ray_intersect_preliminary(ray)
        triangle = np.asarray(dr.select(found.is_valid(), found.prim_index, len(self._patch) - 1))
        return self._patch[triangle]
