"""What casters of rays and of frusta can do, as types."""

from typing import Protocol

import numpy as np

from golden.cast.ray_frusta import FrustumHits
from golden.cast.rays import Hits, Rays

__all__ = ["CastsFrusta", "CastsRays"]


class CastsRays(Protocol):
    """Casts any rays, as `golden.cast.ray_caster.RayCaster` does."""

    def nearest(self, rays: Rays) -> Hits:
        """The nearest hit of each ray."""
        ...

    def any_hit(self, rays: Rays) -> Hits:
        """Some hit of each ray before its ``tmax``."""
        ...

    def occluded(self, origins: np.ndarray, targets: np.ndarray, skip: np.ndarray) -> np.ndarray:
        """Whether a patch lies between two points, K bool."""
        ...


class CastsFrusta(Protocol):
    """Casts frusta, as `golden.cast.ray_frusta.RayFrusta` and `golden.engine.cast.fixed_frusta.FixedFrusta` do."""

    regular: bool

    def hemispheres(self, hemisphere, points, frames, surfaces) -> FrustumHits:
        """Caster of the hemispheres at M points."""
        ...

    def screen(self, screen, side: int) -> FrustumHits:
        """Caster of the rays of a picture."""
        ...
