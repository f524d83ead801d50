"""Luminance and illuminance from the radiances of three channels."""

import numpy as np

from golden.light.tone import luminance

__all__ = ["EFFICACY", "candela_per_m2", "lux"]

EFFICACY = 179.0
"""Luminous efficacy of the scene's white light, lm/W: that of the program Radiance, for equal-energy white."""


def candela_per_m2(radiance: np.ndarray, efficacy: float) -> np.ndarray:
    """Luminance of radiances (..., 3) in W/(m2 sr), for ``efficacy`` in lm/W."""
    return efficacy * luminance(radiance)


def lux(arriving: np.ndarray, efficacy: float) -> np.ndarray:
    """Illuminance of irradiances over pi (..., 3) in W/(m2 sr), for ``efficacy`` in lm/W.

    Of a radiosity over pi it is the luminous exitance, in lm/m2.
    """
    return np.pi * candela_per_m2(arriving, efficacy)
