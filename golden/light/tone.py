"""Tone mapping: from radiance to display values."""

import numpy as np

from golden.base.errors import InputError
from golden.scene.appearance import to_srgb

__all__ = ["CURVES", "automatic_exposure", "check_display", "luminance", "tone_map"]

CURVES = ("reinhard", "linear")

# Exponents of the display's power law that a PNG can state: its file has 10^5 over them as a whole number of 31 bits.
_GAMMAS = 1e-4, 1e4

# A typical scene's log-average is that of a reflectance of 0.18, which the curve below makes of this.
_KEY = 0.18 / (1 - 0.18)

# Share of the pixels that may saturate: lamps, mostly.
_WHITE_SHARE = 0.01


def luminance(image: np.ndarray) -> np.ndarray:
    """Luminance of linear RGB with the primaries of ITU-R BT.709; any shape (..., 3), same units."""
    return image @ np.array([0.2126, 0.7152, 0.0722])


def automatic_exposure(image: np.ndarray) -> float:
    """The factor that brings the log-average luminance of what is lit to middle grey.

    After E. Reinhard and others, Photographic Tone Reproduction for Digital Images, 2002, eq. 1. Black pixels (rays
    that left the scene) do not count; a picture that is black throughout gets 1.
    """
    lit = luminance(image)
    lit = lit[lit > 0]
    return float(_KEY / np.exp(np.log(lit).mean())) if lit.size else 1.0


def check_display(exposure: float | None, gamma: float | None) -> None:
    """Refuse what `tone_map` does not take, for whoever calls it after long work.

    Raises
    ------
    InputError
        Exposure is not a finite value above 0, or gamma is not 0.0001 to 10000.
    """
    if exposure is not None and not (np.isfinite(exposure) and exposure > 0):
        raise InputError(f"tone mapping: Exposure must be a finite value above 0, not {exposure!r}",
                         parameter="exposure")
    if gamma is not None and not _GAMMAS[0] <= gamma <= _GAMMAS[1]:
        raise InputError(f"tone mapping: Gamma must be {_GAMMAS[0]:g} to {_GAMMAS[1]:g}, not {gamma!r}",
                         parameter="gamma")


def tone_map(image: np.ndarray, *, exposure: float | None = None, curve: str = "reinhard",
             gamma: float | None = None, bits: int = 8) -> np.ndarray:
    """H x W x 3 linear radiance as a picture of 8 or 16 bits a channel.

    Parameters
    ----------
    exposure
        Factor before everything else; None chooses `automatic_exposure`.
    curve
        ``"reinhard"``: luminance L becomes L (1 + L/w^2) / (1 + L), where w, a luminance that 1 % of the pixels exceed
        but at least 1, becomes white (the paper's eq. 4; hue is kept). ``"linear"``: clipped at 1.
    gamma
        Power law of the display, 0.0001 to 10000; None is the sRGB curve (IEC 61966-2-1).
    bits
        8 or 16.

    Raises
    ------
    InputError
        Exposure or gamma is out of range, or the curve is unknown.
    """
    check_display(exposure, gamma)
    if curve not in CURVES:
        raise InputError(f"tone mapping: Curve must be {' or '.join(CURVES)}, not {curve!r}")
    linear = image * (automatic_exposure(image) if exposure is None else exposure)
    if curve == "reinhard":
        bright = luminance(linear)
        white = max(1.0, float(np.quantile(bright, 1 - _WHITE_SHARE)))
        linear = linear * ((1 + bright / white**2) / (1 + bright))[..., None]
    linear = np.clip(linear, 0, 1)
    encoded = to_srgb(linear) if gamma is None else linear ** (1 / gamma)
    return np.rint((2**bits - 1) * encoded).astype({8: np.uint8, 16: np.uint16}[bits])
