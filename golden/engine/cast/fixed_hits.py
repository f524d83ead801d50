"""Hits of a frustum's rays in the machine's integers."""

from dataclasses import dataclass

import numpy as np

from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.intersection import hit_uv
from golden.engine.icu.patch_setup import Patches
from golden.engine.icu.ray_memory import RayMemory

__all__ = ["FixedHits", "read_out"]

# Hits per block, such that the arrays of the subdivision stay in a second-level cache.
BLOCK = 1 << 12


@dataclass(frozen=True, kw_only=True, eq=False)
class FixedHits:
    """Hits of R rays, in the order of their numbers.

    Parameters
    ----------
    inverse
        R int64, stored inverse distance; 0 for no hit.
    patch
        R int64, -1 for no hit.
    u, v
        R int64, position on the patch in units of 2^-``uv_bits``; 0 for no hit.
    """

    inverse: np.ndarray
    patch: np.ndarray
    u: np.ndarray
    v: np.ndarray

    def differences(self, other: "FixedHits") -> np.ndarray:
        """Numbers of the rays that differ in any field."""
        return np.flatnonzero((self.inverse != other.inverse) | (self.patch != other.patch)
                              | (self.u != other.u) | (self.v != other.v))


def read_out(memory: RayMemory, record: FrustumRecord, patches: Patches, config: Config) -> FixedHits:
    """The hits in a ray memory, with (u, v), which follow from ray and patch.

    Parameters
    ----------
    memory, record
        The ray memory, and the frustum of its rays.
    patches
        All patches of the scene, in the order of their ids.
    config
        The configuration.
    """
    patch = memory.patch
    hits = np.flatnonzero(patch >= 0)
    u, v = np.zeros((2, len(patch)), dtype=np.int64)
    for start in range(0, len(hits), BLOCK):
        hit = hits[start:start + BLOCK]
        directions = record.directions(hit % record.columns, hit // record.columns)
        u[hit], v[hit] = hit_uv(patches, patch[hit], directions, config)
    return FixedHits(inverse=memory.inverse, patch=patch, u=u, v=v)
