"""The best hit of each ray so far."""

import numpy as np

from golden.cast.oracle import Oracle, ShearedRays
from golden.cast.rays import Hits

__all__ = ["Nearest"]


class Nearest:
    """Keeps the smallest t of each ray, and the smaller patch number of equal ones; the order of hits does not matter.

    Parameters
    ----------
    tmax
        R float64: hits at this distance or farther do not count.

    Members
    -------
    t
        R float64, the best t, or ``tmax``.
    patch
        R int32, the best patch, or -1.
    """

    def __init__(self, tmax: np.ndarray):
        self.t = tmax.copy()
        self.patch = np.full(len(tmax), -1, dtype=np.int32)

    def update(self, ray: np.ndarray, patch: np.ndarray, t: np.ndarray) -> None:
        """Add the hits ``(ray[k], patch[k], t[k])``; a ray may occur several times."""
        order = np.lexsort((patch, t, ray))
        order = order[np.diff(ray[order], prepend=-1) != 0]
        ray, patch, t = ray[order], patch[order], t[order]
        held = self.patch[ray]
        wins = (t < self.t[ray]) | ((t == self.t[ray]) & (patch < held))
        ray = ray[wins]
        self.t[ray] = t[wins]
        self.patch[ray] = patch[wins]

    def hits(self, oracle: Oracle, rays: ShearedRays, *, tests: np.ndarray, steps: np.ndarray) -> Hits:
        """The result, with (u, v) of each hit."""
        hit = np.flatnonzero(self.patch >= 0)
        u, v = np.zeros((2, len(self.t)))
        u[hit], v[hit] = oracle.uv(rays, hit, self.patch[hit])
        return Hits(patch=self.patch, t=np.where(self.patch >= 0, self.t, np.inf), u=u, v=v, tests=tests, steps=steps)
