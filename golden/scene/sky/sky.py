"""Radiance from outside a scene by direction."""

from dataclasses import dataclass

import numpy as np

from golden.scene.sky.distributions import Distribution, horizontal

__all__ = ["Sky"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Sky:
    """A white sky above the horizon and a white ground below it.

    Parameters
    ----------
    distribution
        Relative luminance of the sky.
    diffuse
        Irradiance of the sky on the horizontal plane, W/m2.
    ground
        Radiance of the ground, W/(m2 sr).
    up, sun
        Unit vectors towards the zenith and the sun; the sun itself is a light of the scene.
    """

    distribution: Distribution
    diffuse: float
    ground: float
    up: np.ndarray
    sun: np.ndarray

    def __post_init__(self):
        zenith = float(np.arccos(np.clip(self.up @ self.sun, -1, 1)))
        object.__setattr__(self, "_scale", self.diffuse / horizontal(self.distribution, zenith))

    def radiance(self, direction: np.ndarray) -> np.ndarray:
        """Radiance of what is seen along K x 3 vectors of any length above 0: K x 3."""
        direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
        sine = direction @ self.up
        angle = np.arccos(np.clip(direction @ self.sun, -1, 1))
        seen = np.where(sine > 0, self._scale * self.distribution(sine, angle), self.ground)
        return np.repeat(seen[:, None], 3, axis=1)
