"""Shadow rays: from shaded points to points of lights that many of them share."""

from dataclasses import dataclass

import numpy as np

__all__ = ["ShadowHits", "ShadowRays"]


@dataclass(frozen=True, kw_only=True, eq=False)
class ShadowRays:
    """R shadow rays to L points of lights.

    Parameters
    ----------
    points
        L x 3, scene units.
    surfaces
        L int: the surface (`Scene.surface`) of each of them, which blocks none of its rays, or -1.
    light
        R int: the number of each ray's point of a light.
    targets, normals
        R x 3 each: the shaded points, and unit normals of the planes in which they lie. Nothing in its plane blocks a
        shaded point.
    """

    points: np.ndarray
    surfaces: np.ndarray
    light: np.ndarray
    targets: np.ndarray
    normals: np.ndarray

    def __len__(self) -> int:
        return len(self.light)


@dataclass(frozen=True, kw_only=True, eq=False)
class ShadowHits:
    """What a caster of shadow frusta found.

    Parameters
    ----------
    cast
        R bool: the ray was cast; else too few rays share its point and its direction, or it has no length.
    blocked
        R bool: a patch is between the two points; False for rays that were not cast.
    tests, steps
        R int64, ray-patch tests and cell steps.
    """

    cast: np.ndarray
    blocked: np.ndarray
    tests: np.ndarray
    steps: np.ndarray
