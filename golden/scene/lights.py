"""Lights without an area: points, spots and the sun."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError
from golden.scene.luminaires.photometric_web import PhotometricWeb
from golden.scene.material import BRIGHTEST, Rgb

__all__ = ["Cone", "DirectionalLight", "PointLight"]

# Least difference of the cosines of a cone's angles, so that a sharp edge divides by no zero (KHR_lights_punctual).
SHARPEST = 1e-3


def _check_triple(kind, name, value):
    if len(value) != 3 or not np.all(np.isfinite(value)):
        raise InputError(f"{kind}: {name} must be three finite values, not {value!r}", parameter=name.lower())


def _check_direction(kind, value):
    _check_triple(kind, "Direction", value)
    if not np.linalg.norm(value) > 0:
        raise InputError(f"{kind}: Direction must not be zero, not {value!r}", parameter="direction")


def _check_bright(kind, name, value):
    _check_triple(kind, name, value)
    if not 0 <= min(value) <= max(value) <= BRIGHTEST:
        raise InputError(f"{kind}: {name} must be at least 0 and at most {BRIGHTEST:g}, not {value!r}",
                         parameter=name.lower())


@dataclass(frozen=True, kw_only=True)
class Cone:
    """The cone of a spot light.

    Parameters
    ----------
    direction
        Where the light shines; any length above 0.
    inner, outer
        Angles from the direction in degrees up to which the light has its whole intensity, and from which it has none:
        0 to 90, inner up to outer; equal ones are a sharp edge.

    Raises
    ------
    InputError
        The direction is zero or not finite, or an angle is out of range.

    Source: the glTF extension KHR_lights_punctual, Inner and Outer Cone Angles.
    """

    direction: tuple[float, float, float]
    inner: float = 0.0
    outer: float = 45.0

    def __post_init__(self):
        _check_direction("spot light", self.direction)
        if not 0 <= self.inner <= self.outer <= 90 or not self.outer:
            raise InputError(f"spot light: Angles must be 0 to 90 degrees, the inner up to the outer one, not "
                             f"{self.inner!r} and {self.outer!r}")

    def factor(self, toward: np.ndarray) -> np.ndarray:
        """What multiplies the intensity in K directions towards the light, K x 3 of any length: 0 to 1."""
        direction = np.asarray(self.direction) / np.linalg.norm(self.direction)
        inner, outer = np.cos(np.radians((self.inner, self.outer)))
        cosine = -(toward @ direction) / np.linalg.norm(toward, axis=1)
        return np.clip((cosine - outer) / max(SHARPEST, inner - outer), 0, 1) ** 2


@dataclass(frozen=True, kw_only=True)
class PointLight:
    """A point light: ``intensity`` in W/sr per channel at ``position``.

    It shines in all directions, within a cone, or with its intensity times that of a photometric web.
    """

    position: tuple[float, float, float]
    intensity: Rgb
    cone: Cone | None = None
    web: PhotometricWeb | None = None

    def __post_init__(self):
        _check_triple("point light", "Position", self.position)
        _check_bright("point light", "Intensity", self.intensity)


@dataclass(frozen=True, kw_only=True)
class DirectionalLight:
    """A light at infinity: it shines along ``direction``, with a normal ``irradiance`` in W/m2 per channel."""

    direction: tuple[float, float, float]
    irradiance: Rgb

    def __post_init__(self):
        _check_direction("directional light", self.direction)
        _check_bright("directional light", "Irradiance", self.irradiance)
