"""What rays see: the points that they hit, from the side that they come from."""

import numpy as np

from golden.base.compiled import compiled
from golden.cast.rays import Hits, Rays
from golden.light.surface_points import SurfacePoints, corner_normals
from golden.scene.scene import Scene

__all__ = ["SeenPoints"]


class SeenPoints:
    """Finds the points of rays with known hits."""

    def __init__(self, scene: Scene):
        self._normals, self._corner_normals = scene.normals, corner_normals(scene)

    def at(self, rays: Rays, hits: Hits, met: np.ndarray) -> tuple[SurfacePoints, np.ndarray, np.ndarray]:
        """The points of the K rays numbered ``met``, their unit directions K x 3, and whether each is on a front."""
        count = len(met)
        position, normal, direction = np.empty((3, count, 3))
        front = np.empty(count, dtype=bool)
        _find(rays.origin, rays.direction, hits.t, hits.patch, hits.u, hits.v, met, self._normals,
              self._corner_normals, position, normal, direction, front)
        return SurfacePoints(position, normal, hits.patch[met]), direction, front


@compiled
def _find(origin, along, t, patch, u, v, met, normals, corners, position, normal, direction, front):
    for k in range(len(met)):
        ray = met[k]
        own, x, y = patch[ray], u[ray], v[ray]
        length = np.sqrt(along[ray, 0] * along[ray, 0] + along[ray, 1] * along[ray, 1] + along[ray, 2] * along[ray, 2])
        facing, size = 0.0, 0.0
        for axis in range(3):
            position[k, axis] = origin[ray, axis] + t[ray] * along[ray, axis]
            direction[k, axis] = along[ray, axis] / length
            facing += direction[k, axis] * normals[own, axis]
            # Bilinear between the normals at the corners.
            normal[k, axis] = ((1 - y) * ((1 - x) * corners[own, 0, axis] + x * corners[own, 1, axis])
                               + y * ((1 - x) * corners[own, 3, axis] + x * corners[own, 2, axis]))
            size += normal[k, axis] * normal[k, axis]
        front[k] = facing < 0
        scale = (1 if front[k] else -1) / np.sqrt(size)
        for axis in range(3):
            normal[k, axis] *= scale
