"""Where rays meet patches that they are known to hit."""

import numpy as np

from golden.cast.rays import Hits, Rays
from golden.oracle import Oracle

__all__ = ["hits_of_patches"]


def hits_of_patches(oracle: Oracle, rays: Rays, patch: np.ndarray, *, tests: np.ndarray, steps: np.ndarray) -> Hits:
    """The hits in float64 of rays whose nearest patches another caster has found.

    That caster may have rounded: t is where the ray meets the patch's plane, but no nearer and no farther than the
    patch's vertices lie along the ray, and (u, v) of a ray beside the patch is on its border.

    Parameters
    ----------
    rays
        R rays.
    patch
        R, -1 for no hit.
    tests, steps
        R int64, what the other caster spent.
    """
    hit = np.flatnonzero(patch >= 0)
    which, direction = patch[hit], rays.direction[hit]
    vertices = oracle.scene.vertices[which] - rays.origin[hit, None]
    along = np.einsum("kij,kj->ki", vertices, direction) / np.einsum("kj,kj->k", direction, direction)[:, None]
    normal = oracle.scene.normals[which]
    offset = np.einsum("kj,kij->k", normal, vertices) / 4
    fall = np.einsum("kj,kj->k", normal, direction)
    # A ray that only rounding lets reach the plane meets it far away.
    meets = offset * fall > 0
    far = along.max(axis=1)
    t = np.full(len(rays), np.inf)
    t[hit] = np.clip(np.where(meets, offset / np.where(meets, fall, 1), far), np.maximum(along.min(axis=1), 0), far)
    u, v = np.zeros((2, len(rays)))
    u[hit], v[hit] = oracle.uv(oracle.sheared(rays), hit, which)
    return Hits(patch=patch.astype(np.int32), t=t, u=u, v=v, tests=tests, steps=steps)
