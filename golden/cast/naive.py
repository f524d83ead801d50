"""Brute force in float64: all patches against all rays."""

import numpy as np

from golden.cast.nearest import Nearest
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
        sheared = self.oracle.sheared(rays)
        best = Nearest(rays.tmax)
        block = max(1, BLOCK // len(self.oracle.scene))
        for axis in range(3):
            members = np.flatnonzero(sheared.axis == axis)
            for start in range(0, len(members), block):
                best.update(*self.oracle.all_hits(sheared, members[start:start + block]))
        tests = np.full(len(rays), len(self.oracle.scene))
        return best.hits(self.oracle, sheared, tests=tests, steps=np.zeros_like(tests))

    def any_hit(self, rays: Rays) -> Hits:
        """A hit of each ray before its ``tmax``: here the nearest one."""
        return self.nearest(rays)
