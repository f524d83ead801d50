"""Intersection: pairs of a ray and a patch, from directions to inverse distances and (u, v)."""

import numpy as np

from golden.engine.config import Config
from golden.engine.icu.inverse_distance import inverse_distance
from golden.engine.icu.patch_setup import Patches
from golden.engine.icu.screening import edge_distances, inside
from golden.engine.icu.uv_subdivision import align, uv_subdivision

__all__ = ["hit_uv", "intersect"]


def intersect(patches: Patches, which: np.ndarray, directions: np.ndarray,
              config: Config) -> tuple[np.ndarray, np.ndarray]:
    """Which of the K pairs of patch ``which[k]`` and a ray with ``directions[k]`` (K x 3) meet.

    Returns
    -------
    tuple
        The numbers k of those that meet, and their stored inverse distances.
    """
    planes = patches.planes[which]
    pair = np.flatnonzero(inside(edge_distances(planes, directions, config.numbers), planes)[0] & patches.live[which])
    return pair, inverse_distance(patches.factor[which[pair]], directions[pair], config.numbers)


def hit_uv(patches: Patches, which: np.ndarray, directions: np.ndarray,
           config: Config) -> tuple[np.ndarray, np.ndarray]:
    """(u, v) of K pairs that are known to meet: K int64 each, units of 2^-``uv_bits``."""
    planes = patches.planes[which]
    distances = edge_distances(planes, directions, config.numbers)
    _, orientation = inside(distances, planes)
    return uv_subdivision(align(distances, patches.exponents[which], config.icu), orientation, config.icu)
