"""What casters of single rays share: threads, and segments between two points."""

from abc import abstractmethod
from copy import copy
from dataclasses import replace
from itertools import pairwise

import numpy as np

from golden.base.errors import InputError
from golden.base.processors import threads_of
from golden.base.spread import in_threads
from golden.cast.oracle import Oracle
from golden.cast.ray_frusta import RayFrusta
from golden.cast.rays import Hits, Rays

__all__ = ["RayCaster"]


class RayCaster(RayFrusta):
    """Base class of the casters that cast any rays.

    Parameters
    ----------
    jobs
        Threads that may cast at once, at least 1. Default: one per processor that this process may use.

    Members
    -------
    oracle
        The tests of the scene's patches.
    least
        Least distance of a hit from both ends of a segment, in scene units.
    jobs
        See above.

    Raises
    ------
    InputError
        Jobs out of range.
    """

    oracle: Oracle

    def __init__(self, jobs: int | None):
        self.jobs = threads_of(jobs)

    @property
    def least(self) -> float:
        """That of the oracle."""
        return self.oracle.nearest

    def with_jobs(self, jobs: int | None) -> "RayCaster":
        """The same caster with so many threads."""
        threads = threads_of(jobs)
        if threads == self.jobs:
            return self
        other = copy(self)
        other.jobs = threads
        return other

    def _in_threads(self, part, count, *, least, shares):
        """Call ``part`` with slices of ``count`` rays; none writes what another reads."""
        shares = max(1, min(shares, count // least))
        borders = np.linspace(0, count, shares + 1).astype(int)
        for _ in in_threads(self.jobs)(lambda begin, end: part(slice(begin, end)), pairwise(borders.tolist())):
            pass

    def nearest(self, rays: Rays) -> Hits:
        """The nearest hit of each ray before its ``tmax``.

        Equal t goes to the smaller patch number, and of two patches back to back (`Scene`) to the one that faces the
        ray.
        """
        hits = self._nearest(rays)
        patch = self.oracle.scene.facing(hits.patch, rays.direction)
        turned = np.flatnonzero(patch != hits.patch)
        if not len(turned):
            return hits
        u, v = hits.u.copy(), hits.v.copy()
        u[turned], v[turned] = self.oracle.uv(self.oracle.sheared(rays[turned]), np.arange(len(turned)), patch[turned])
        return replace(hits, patch=patch, u=u, v=v)

    @abstractmethod
    def _nearest(self, rays: Rays) -> Hits:
        """The nearest hit of each ray before its ``tmax``; equal t goes to the smaller patch number."""

    def nearest_patches(self, rays: Rays) -> np.ndarray:
        """The patch that each ray hits first, R int32, or -1."""
        return self.nearest(rays).patch

    @abstractmethod
    def any_hit(self, rays: Rays) -> Hits:
        """Some hit of each ray before its ``tmax``."""

    def blocked(self, rays: Rays) -> np.ndarray:
        """Whether each ray hits anything before its ``tmax``, R bool."""
        return self.any_hit(rays).patch >= 0

    def occluded(self, origins: np.ndarray, targets: np.ndarray, skip: np.ndarray) -> np.ndarray:
        """Whether a patch is between two points, for R pairs of them.

        A patch counts if the segment meets it farther than ``least`` from both points.

        Parameters
        ----------
        origins, targets
            R x 3, scene units.
        skip
            R x 2 int: the surfaces (``Scene.surface``) of the two points, which never block, or -1.

        Returns
        -------
        R bool.

        Raises
        ------
        InputError
            Shapes do not match, a value is not finite, or a point is too far away.
        """
        origins, targets = np.asarray(origins, dtype=np.float64), np.asarray(targets, dtype=np.float64)
        skip = np.asarray(skip, dtype=np.int32)
        if origins.shape != targets.shape or skip.shape != (len(origins), 2):
            raise InputError(f"segments: Origins, targets and skip must be R x 3, R x 3 and R x 2, not "
                             f"{origins.shape!r}, {targets.shape!r} and {skip.shape!r}")
        along = targets - origins
        # Between nearer points there is no place for a hit.
        apart = np.flatnonzero(np.abs(along).max(axis=1, initial=0) > self.least)
        if len(apart) < len(along):
            blocked = np.zeros(len(along), dtype=bool)
            blocked[apart] = self.occluded(origins[apart], targets[apart], skip[apart])
            return blocked
        x, y, z = along.T
        tmax = np.maximum(1 - self.least / np.sqrt(x * x + y * y + z * z), 0)
        return self.blocked(Rays(origins, along, source=skip[:, 0], tmax=tmax, target=skip[:, 1]))
