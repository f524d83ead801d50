"""Luminance and illuminance from the radiances of three channels."""

from numbers import Real

import numpy as np

from golden.base.errors import InputError
from golden.light.tone import luminance

__all__ = ["EFFICACY", "candela_per_m2", "check_efficacy", "lux"]

EFFICACY = 179.0
"""Luminous efficacy of the scene's white light, lm/W: that of the program Radiance, for equal-energy white."""


def check_efficacy(efficacy: float) -> None:
    """A luminous efficacy in lm/W is finite and above 0.

    Raises
    ------
    InputError
        It is not.
    """
    if isinstance(efficacy, bool) or not isinstance(efficacy, Real) or not 0 < efficacy < np.inf:
        raise InputError(f"Efficacy must be finite and above 0 lm/W, not {efficacy!r}", parameter="efficacy")


def candela_per_m2(radiance: np.ndarray, efficacy: float) -> np.ndarray:
    """Luminance of radiances (..., 3) in W/(m2 sr), for ``efficacy`` in lm/W, see `check_efficacy`."""
    check_efficacy(efficacy)
    return efficacy * luminance(radiance)


def lux(arriving: np.ndarray, efficacy: float) -> np.ndarray:
    """Illuminance of irradiances over pi (..., 3) in W/(m2 sr), for ``efficacy`` in lm/W, see `check_efficacy`.

    Of a radiosity over pi it is the luminous exitance, in lm/m2.
    """
    return np.pi * candela_per_m2(arriving, efficacy)
