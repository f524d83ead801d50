"""Positions of hits on known patches."""

import numpy as np

from golden.cast.oracle import Oracle
from golden.cast.rays import Hits, Rays

__all__ = ["hits_of_patches"]


def hits_of_patches(oracle: Oracle, rays: Rays, patch: np.ndarray, *, tests: np.ndarray, steps: np.ndarray) -> Hits:
    """The hits in float64 of rays whose nearest patches another caster has found.

    That caster may have rounded. t is at the patch's plane, clipped to the range of the patch's vertices along the ray;
    (u, v) of a ray beside the patch is on its border.

    Parameters
    ----------
    rays
        R rays.
    patch
        R int, -1 for no hit; of two patches back to back (`Scene`) either.
    tests, steps
        R int64, counts of the other caster.
    """
    patch = oracle.scene.facing(patch, rays.direction)
    hit = np.flatnonzero(patch >= 0)
    which, direction = patch[hit], rays.direction[hit]
    vertices = oracle.scene.vertices[which] - rays.origin[hit, None]
    along = np.einsum("kij,kj->ki", vertices, direction) / np.einsum("kj,kj->k", direction, direction)[:, None]
    normal = oracle.scene.normals[which]
    offset = np.einsum("kj,kij->k", normal, vertices) / 4
    fall = np.einsum("kj,kj->k", normal, direction)
    # A ray that reaches the plane by rounding only gets the farthest t.
    meets = offset * fall > 0
    far = along.max(axis=1)
    t = np.full(len(rays), np.inf)
    t[hit] = np.clip(np.where(meets, offset / np.where(meets, fall, 1), far), np.maximum(along.min(axis=1), 0), far)
    u, v = np.zeros((2, len(rays)))
    u[hit], v[hit] = oracle.uv(oracle.sheared(rays), hit, which)
    return Hits(patch=patch.astype(np.int32), t=t, u=u, v=v, tests=tests, steps=steps)
