"""Brute force in fixed point: all patches against all rays in the machine's integers, without windows."""

import numpy as np

from golden.engine.cast.fixed_hits import FixedHits, read_out
from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord
from golden.engine.frustum.shadow_record import ShadowRecord
from golden.engine.icu.inverse_distance import inverse_distance
from golden.engine.icu.patch_setup import PatchSetup
from golden.engine.icu.ray_memory import RayMemory
from golden.engine.icu.screening import cones, inside_cones
from golden.engine.icu.shadow_memory import ShadowMemory
from golden.engine.scene.patch_geometry import PatchGeometry

__all__ = ["NaiveFixed"]

# Rays and cones per block, such that their products stay in a second-level cache.
RAYS, CONES = 1 << 12, 4


class NaiveFixed:
    """The reference of shelling and of the machine: no cells, no windows, no test omitted.

    Parameters
    ----------
    geometry, config
        The patches, and the configuration.
    """

    def __init__(self, geometry: PatchGeometry, config: Config):
        self._geometry, self._config = geometry, config

    def cast(self, record: FrustumRecord, rays: np.ndarray | None = None) -> FixedHits:
        """The nearest hit of each ray; of some ``rays`` alone, by their numbers, if they are given.

        Raises
        ------
        InputError
            The frustum has more rays than ``icu.rays``.
        """
        memory = RayMemory(len(record), self._config)
        return read_out(memory, record, self._update(
            memory, record, np.arange(len(record)) if rays is None else rays), self._config)

    def blocked(self, record: ShadowRecord) -> np.ndarray:
        """Whether anything is before the end of each ray of a shadow frustum: R bool.

        Raises
        ------
        InputError
            The frustum has more rays than ``icu.rays``.
        """
        memory = ShadowMemory(record, self._config)
        self._update(memory, record, np.flatnonzero(record.end < self._config.numbers.inverse.high))
        return memory.blocked

    def _update(self, memory, record, rays):
        """Add the hits of some rays; returns the patches."""
        config = self._config
        patches = PatchSetup(record, config).patches(self._geometry)
        owner, planes = cones(patches.planes)
        keep = patches.live[owner]
        owner, planes = owner[keep], planes[keep]
        directions = record.directions(rays % record.columns, rays // record.columns)
        for start in range(0, len(rays), RAYS):
            block = directions[start:start + RAYS]
            for first in range(0, len(owner), CONES):
                cone, ray = inside_cones(planes[first:first + CONES], block)
                patch = owner[first + cone]
                inverse = inverse_distance(patches.factor[patch], block[ray], config.numbers)
                memory.update(rays[start + ray], inverse, patch)
        return patches
