"""Relative luminances of skies."""

from collections.abc import Callable
from functools import partial

import numpy as np

from golden.scene.sky.weather import clearness_class

__all__ = ["Distribution", "cie_clear", "cie_overcast", "horizontal", "perez", "uniform"]

# Of directions above the horizon, by the sines of their elevation and their angles from the sun in radians. It can be
# pickled: workers get the scene.
Distribution = Callable[[np.ndarray, np.ndarray], np.ndarray]

# A direction counts as at least so high, as a sine: gradation functions have a pole at the horizon.
LOWEST = 0.01
# Points of the quadrature over the sky, in elevation and in azimuth.
_ELEVATIONS, _AZIMUTHS = 128, 256

# Of each of Perez's classes of clearness the coefficients of a to e, four each.
_PEREZ = np.array([
    (1.3525, -0.2576, -0.2690, -1.4366, -0.7670, 0.0007, 1.2734, -0.1233, 2.8000, 0.6004, 1.2375, 1.0000,
     1.8734, 0.6297, 0.9738, 0.2809, 0.0356, -0.1246, -0.5718, 0.9938),
    (-1.2219, -0.7730, 1.4148, 1.1016, -0.2054, 0.0367, -3.9128, 0.9156, 6.9750, 0.1774, 6.4477, -0.1239,
     -1.5798, -0.5081, -1.7812, 0.1080, 0.2624, 0.0672, -0.2190, -0.4285),
    (-1.1000, -0.2515, 0.8952, 0.0156, 0.2782, -0.1812, -4.5000, 1.1766, 24.7219, -13.0812, -37.7000, 34.8438,
     -5.0000, 1.5218, 3.9229, -2.6204, -0.0156, 0.1597, 0.4199, -0.5562),
    (-0.5484, -0.6654, -0.2672, 0.7117, 0.7234, -0.6219, -5.6812, 2.6297, 33.3389, -18.3000, -62.2500, 52.0781,
     -3.5000, 0.0016, 1.1477, 0.1062, 0.4659, -0.3296, -0.0876, -0.0329),
    (-0.6000, -0.3566, -2.5000, 2.3250, 0.2937, 0.0496, -5.6812, 1.8415, 21.0000, -4.7656, -21.5906, 7.2492,
     -3.5000, -0.1554, 1.4062, 0.3988, 0.0032, 0.0766, -0.0656, -0.1294),
    (-1.0156, -0.3670, 1.0078, 1.4051, 0.2875, -0.5328, -3.8500, 3.3750, 14.0000, -0.9999, -7.1406, 7.5469,
     -3.4000, -0.1078, -1.0750, 1.5702, -0.0672, 0.4016, 0.3017, -0.4844),
    (-1.0000, 0.0211, 0.5025, -0.5119, -0.3000, 0.1922, 0.7023, -1.6317, 19.0000, -5.0000, 1.2438, -1.9094,
     -4.0000, 0.0250, 0.3844, 0.2656, 1.0468, -0.3788, -2.4517, 1.4656),
    (-1.0500, 0.0289, 0.4260, 0.3590, -0.3250, 0.1156, 0.7781, 0.0025, 31.0625, -14.5000, -46.1148, 55.3750,
     -7.2312, 0.4050, 13.3500, 0.6234, 1.5000, -0.6426, 1.8564, 0.5636)]).reshape(8, 5, 4)


def uniform() -> Distribution:
    """The same luminance everywhere."""
    return _uniform


def cie_overcast() -> Distribution:
    """The zenith three times as bright as the horizon: (1 + 2 sin elevation) / 3.

    Source: Moon and Spencer 1942; CIE S 011 (ISO 15469:2004), the traditional overcast sky.
    """
    return _cie_overcast


def cie_clear() -> Distribution:
    """A clear sky of low turbidity, relative to an arbitrary unit.

    Source: CIE S 011 (ISO 15469:2004), type 12.
    """
    c, d = 10.0, -3.0
    return partial(_gradation_and_scattering, a=-1.0, b=-0.32, c=c, d=d, e=0.45, offset=c * np.exp(d * np.pi / 2))


def perez(clearness: float, brightness: float, zenith: float) -> Distribution:
    """The all-weather sky, relative to an arbitrary unit.

    Parameters
    ----------
    clearness, brightness
        Perez's epsilon, at least 1, and Delta.
    zenith
        The sun's angle from the zenith in radians, 0 to pi/2.

    Source: Perez, Seals, Michalsky, All-weather model for sky luminance distribution (1993), with its erratum. As
    in Radiance's gendaylit the brightness is 0.01 to 0.6, and at least 0.2 in the classes 1.065 to 2.8.
    """
    number = clearness_class(clearness)
    brightness = min(max(brightness, 0.2 if 1 <= number <= 4 else 0.01), 0.6)
    rows = _PEREZ[number]
    a, b, c, d, e = rows @ np.array([1, zenith, brightness, brightness * zenith])
    if number == 0:
        _, _, (c1, c2, c3, c4), (d1, d2, d3, d4), _ = rows
        c = np.exp((brightness * (c1 + c2 * zenith)) ** c3) - c4
        d = -np.exp(brightness * (d1 + d2 * zenith)) + d3 + d4 * brightness
    return partial(_gradation_and_scattering, a=a, b=b, c=c, d=d, e=e)


def horizontal(distribution: Distribution, zenith: float) -> float:
    """Irradiance of the sky on the horizontal plane, for a sun at an angle from the zenith in radians."""
    knots, weights = np.polynomial.legendre.leggauss(_ELEVATIONS)
    # Evenly spaced in elevation, the points are dense at the horizon, where gradations are steep.
    elevation = (knots + 1) * np.pi / 4
    azimuth = (np.arange(_AZIMUTHS) + 0.5) * 2 * np.pi / _AZIMUTHS
    sine, cosine = np.sin(elevation)[:, None], np.cos(elevation)[:, None]
    toward = sine * np.cos(zenith) + cosine * np.sin(zenith) * np.cos(azimuth)
    values = distribution(np.broadcast_to(sine, toward.shape), np.arccos(np.clip(toward, -1, 1)))
    return float((values.mean(axis=1) * sine[:, 0] * cosine[:, 0]) @ weights * np.pi**2 / 2)


def _uniform(sine, angle):
    return np.ones_like(sine)


def _cie_overcast(sine, angle):
    return (1 + 2 * sine) / 3


def _gradation_and_scattering(sine, angle, *, a, b, c, d, e, offset=0.0):
    """(1 + a exp(b / sin elevation)) (1 + c exp(d angle) - ``offset`` + e cos^2 angle), at least 0."""
    gradation = 1 + a * np.exp(b / np.maximum(sine, LOWEST))
    return np.maximum(gradation * (1 + c * np.exp(d * angle) - offset + e * np.cos(angle) ** 2), 0)
