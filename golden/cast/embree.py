"""Casting with Embree, in single precision."""

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from golden.cast.known_patches import hits_of_patches
from golden.cast.ray_caster import RayCaster
from golden.cast.rays import Hits, Rays
from golden.oracle import Oracle
from golden.scene.scene import Scene

__all__ = ["Embree"]

# Least distance of a hit, and how far a ray goes on behind a patch that it never hits, as shares of the scene's size;
# each time twice as far.
STEP = 2.0**-20
# Most patches in a row that a ray never hits.
MOST_SKIPPED = 16
# Rays per call.
BLOCK = 1 << 16


class Embree(RayCaster):
    """Casts over two triangles per quadrilateral, with the scene moved to the origin and scaled to a unit cube.

    Single precision keeps positions to 2^-24 of the scene's size: rays near an edge, patches nearly at one depth and
    gaps below 2^-20 of the scene's size may differ from ``naive``.

    Parameters
    ----------
    scene
        The patches.

    Raises
    ------
    ModuleNotFoundError
        embreex is not installed.
    InputError
        Float64 does not resolve the scene.
    """

    def __init__(self, scene: Scene):
        self.oracle = Oracle(scene)
        second = np.flatnonzero(~scene.is_triangle)
        triangles = np.concatenate([scene.vertices[:, :3], scene.vertices[second][:, [0, 2, 3]]])
        self._patch = np.append(np.concatenate([np.arange(len(scene)), second]), -1).astype(np.int32)
        self._embree = EmbreeScene()
        # The scene does not hold its mesh.
        self._mesh = TriangleMesh(self._embree, self._unit(triangles).reshape(-1, 3).astype(np.float32),
                                  np.arange(3 * len(triangles), dtype=np.int32).reshape(-1, 3))

    def _unit(self, points):
        """Points in the unit cube of the scene box."""
        return (points - self.oracle.scene.bounds[0]) / self.oracle.scene.size

    @property
    def least(self) -> float:
        """What single precision resolves."""
        return STEP * self.oracle.scene.size

    def nearest(self, rays: Rays) -> Hits:
        """The nearest hit of each ray before its ``tmax``; t, u and v in float64 on the patch that Embree finds."""
        unknown = np.zeros(len(rays), dtype=np.int64)
        return hits_of_patches(self.oracle, rays, self.nearest_patches(rays), tests=unknown, steps=unknown)

    def nearest_patches(self, rays: Rays) -> np.ndarray:
        """The patch that each ray hits first, R int32, or -1."""
        self.oracle.check(rays)
        patch = np.empty(len(rays), dtype=np.int32)
        for first in range(0, len(rays), BLOCK):
            patch[first:first + BLOCK] = self._first_patches(rays[slice(first, first + BLOCK)])
        return patch

    def any_hit(self, rays: Rays) -> Hits:
        """A hit of each ray before its ``tmax``: here the nearest one."""
        return self.nearest(rays)

    def _first_patches(self, rays):
        """The first patch of each ray, R int32, or -1."""
        surface, found = self.oracle.scene.surface, np.full(len(rays), -1, dtype=np.int32)
        origin, length = self._unit(rays.origin), np.linalg.norm(rays.direction, axis=1)
        direction, end = rays.direction / length[:, None], rays.tmax * length / self.oracle.scene.size
        live, gone, step = np.arange(len(rays)), np.zeros(len(rays)), STEP
        for _ in range(MOST_SKIPPED):
            start = origin[live] + gone[live, None] * direction[live]
            left = np.minimum(end[live] - gone[live], np.finfo(np.float32).max).astype(np.float32)
            answer = self._embree.run(start.astype(np.float32), direction[live].astype(np.float32), dists=left,
                                      output=1)
            patch = self._patch[answer["primID"]]
            own = (surface[patch] == rays.source[live]) | (surface[patch] == rays.target[live])
            own |= gone[live] + answer["tfar"] < STEP
            met = patch >= 0
            found[live[met & ~own]] = patch[met & ~own]
            live, again = live[met & own], answer["tfar"][met & own]
            if not len(live):
                break
            gone[live] += again + step
            live = live[gone[live] < end[live]]
            step *= 2
        return found
