"""Perez's indices of the weather, and the illuminances that they predict."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError

__all__ = ["Weather", "clearness_class"]

# Irradiance outside the atmosphere in W/m2, at the mean distance of the sun.
_EXTRATERRESTRIAL = 1367.0
# Water in the atmosphere, cm, where it is unknown.
_WATER = 2.0
# Upper ends of the classes of clearness.
_CLEARNESS = (1.065, 1.23, 1.5, 1.95, 2.8, 4.5, 6.2)
# Coefficients of the luminous efficacies of diffuse and direct light in lm/W, by class.
_DIFFUSE = np.array([(97.24, -0.46, 12.00, -8.91), (107.22, 1.15, 0.59, -3.95), (104.97, 2.96, -5.53, -8.77),
                     (102.39, 5.59, -13.95, -13.90), (100.71, 5.94, -22.75, -23.74), (106.42, 3.83, -36.15, -28.83),
                     (141.88, 1.90, -53.24, -14.03), (152.23, 0.35, -45.27, -7.98)])
_DIRECT = np.array([(57.20, -4.55, -2.98, 117.12), (98.99, -3.46, -1.21, 12.38), (109.83, -4.90, -1.71, -8.81),
                    (110.34, -5.84, -1.99, -4.56), (106.36, -3.97, -1.75, -6.16), (107.19, -1.25, -1.51, -26.73),
                    (105.75, 0.77, -1.26, -34.44), (101.18, 1.58, -1.10, -8.29)])


def clearness_class(clearness: float) -> int:
    """The number of a clearness' class, 0 (overcast) to 7 (clear)."""
    return int(np.searchsorted(_CLEARNESS, clearness, side="right"))


@dataclass(frozen=True, kw_only=True)
class Weather:
    """Direct normal and diffuse horizontal irradiance in W/m2, and the sun's angle from the zenith in radians.

    Source: Perez, Ineichen, Seals, Michalsky, Stewart, Modeling daylight availability and irradiance components from
    direct and global irradiance (1990), equations 1, 2, 7, 8 and table 4; Kasten's air mass (1965).
    """

    direct: float
    diffuse: float
    zenith: float

    def check(self) -> None:
        """Raise `InputError` if an irradiance is out of range."""
        if not (0 <= self.direct <= _EXTRATERRESTRIAL and 0 < self.diffuse <= _EXTRATERRESTRIAL):
            raise InputError(f"daylight: Weather must be two irradiances of up to {_EXTRATERRESTRIAL:g} W/m2, the "
                             f"diffuse one above 0, not {self.direct!r},{self.diffuse!r}", parameter="weather")

    @property
    def clearness(self) -> float:
        """Epsilon."""
        bent = 1.041 * self.zenith**3
        return ((self.diffuse + self.direct) / self.diffuse + bent) / (1 + bent)

    @property
    def brightness(self) -> float:
        """Delta."""
        degrees = np.degrees(self.zenith)
        mass = 1 / (np.cos(self.zenith) + 0.15 * (93.885 - degrees) ** -1.253)
        return float(self.diffuse * mass / _EXTRATERRESTRIAL)

    @property
    def illuminances(self) -> tuple[float, float]:
        """Diffuse horizontal and direct normal illuminance in lux."""
        row = clearness_class(self.clearness)
        brightness = max(self.brightness, 0.01)
        diffuse = _DIFFUSE[row] @ (1, _WATER, np.cos(self.zenith), np.log(brightness))
        direct = _DIRECT[row] @ (1, _WATER, np.exp(5.73 * self.zenith - 5), brightness)
        return float(self.diffuse * diffuse), float(max(0.0, self.direct * direct))
