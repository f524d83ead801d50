"""Brute force in float64: all patches against all rays."""

import numpy as np

from golden.cast.oracle import Oracle
from golden.cast.ray_caster import RayCaster
from golden.cast.rays import Hits, Rays
from golden.scene.scene import Scene

__all__ = ["Naive"]

# Pairs per block, such that their two dozen float64 arrays stay in a second-level cache.
BLOCK = 1 << 14


class Naive(RayCaster):
    """Tests every ray against every patch in float64: the reference of `golden.cast.grid.Grid`.

    Parameters
    ----------
    scene
        The patches.
    """

    def __init__(self, scene: Scene):
        super().__init__(1)
        self.oracle = Oracle(scene)

    def _nearest(self, rays):
        oracle, sheared = self.oracle, self.oracle.sheared(rays)
        count, block = len(rays), max(1, BLOCK // len(oracle.scene))
        patch, t, (u, v) = np.full(count, -1, dtype=np.int32), np.full(count, np.inf), np.zeros((2, count))
        for axis in range(3):
            members = np.flatnonzero(sheared.axis == axis)
            for start in range(0, len(members), block):
                ray, which, depth = _first(*oracle.all_hits(sheared, members[start:start + block]), rays.tmax)
                patch[ray], t[ray] = which, depth
        hit = np.flatnonzero(patch >= 0)
        u[hit], v[hit] = oracle.uv(sheared, hit, patch[hit])
        tests = np.full(count, len(oracle.scene))
        return Hits(patch=patch, t=t, u=u, v=v, tests=tests, steps=np.zeros_like(tests))

    def any_hit(self, rays: Rays) -> Hits:
        """A hit of each ray before its ``tmax``: here the nearest one."""
        return self.nearest(rays)


def _first(ray, patch, t, tmax):
    """The nearest of the hits of each ray, the smaller patch number of equal ones; none at ``tmax`` or farther."""
    order = np.lexsort((patch, t, ray))
    order = order[np.diff(ray[order], prepend=-1) != 0]
    order = order[t[order] < tmax[ray[order]]]
    return ray[order], patch[order], t[order]
