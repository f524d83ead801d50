"""Luminous intensity of a luminaire by direction."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError
from golden.scene.material import BRIGHTEST

__all__ = ["PhotometricWeb"]


@dataclass(frozen=True, kw_only=True, eq=False)
class PhotometricWeb:
    """Intensities in C planes, linear in both angles between the given ones.

    Parameters
    ----------
    gamma
        G angles from the luminaire's axis in degrees, 0 (the direction in which it aims) to 180, ascending. Beyond the
        first and the last one there is no light.
    planes
        C angles around the axis in degrees, ascending: one of 0, if the light is the same all around, or 0 to 360.
    candela
        C x G intensities, at least 0.
    axes
        3 x 3: unit vectors along C0, along C90, and along the axis, as rows.

    Raises
    ------
    InputError
        Angles do not ascend or are out of range, or intensities are negative, above `BRIGHTEST` or of another shape.

    Source: CIE 121, the system of C planes.
    """

    gamma: np.ndarray
    planes: np.ndarray
    candela: np.ndarray
    axes: np.ndarray

    def __post_init__(self):
        for name in ("gamma", "planes", "candela", "axes"):
            object.__setattr__(self, name, np.asarray(getattr(self, name), dtype=np.float64))
        gamma, planes = self.gamma, self.planes
        for name, angles, top in (("Vertical", gamma, 180), ("Horizontal", planes, 360)):
            if not (len(angles) and np.isfinite(angles).all() and (np.diff(angles) > 0).all()
                    and angles[0] >= 0 and angles[-1] <= top):
                raise InputError(f"{name} angles must ascend from 0 to {top} degrees, not be "
                                 f"{', '.join(f'{angle:g}' for angle in angles[:4])} ... {angles[-1:]}")
        if len(gamma) < 2:
            raise InputError(f"Vertical angles must be at least two, not {len(gamma)}")
        if len(planes) > 1 and not (planes[0] == 0 and planes[-1] == 360):
            raise InputError(f"Horizontal angles must be 0 alone, or 0 to 360 degrees, not {planes[0]:g} to "
                             f"{planes[-1]:g}")
        if self.candela.shape != (len(planes), len(gamma)):
            raise InputError(f"Intensities must be {len(planes)} x {len(gamma)}, not {self.candela.shape!r}")
        if not ((self.candela >= 0) & (self.candela <= BRIGHTEST)).all():
            raise InputError(f"Intensities must be at least 0 and at most {BRIGHTEST:g}")

    def factor(self, toward: np.ndarray) -> np.ndarray:
        """What multiplies a light's intensity in K directions towards the luminaire, K x 3 of any length: candela."""
        along, across, down = -(toward @ self.axes.T).T
        gamma = np.degrees(np.arctan2(np.hypot(along, across), down))
        plane = np.degrees(np.arctan2(across, along)) % 360
        column, x = _between(self.gamma, gamma)
        row, y = _between(self.planes, plane)
        corners = self.candela[row[:, None] + [0, 0, 1, 1] if len(self.planes) > 1 else row[:, None] + [0, 0, 0, 0],
                               column[:, None] + [0, 1, 0, 1]]
        shares = np.stack([(1 - y) * (1 - x), (1 - y) * x, y * (1 - x), y * x], axis=1)
        # Rounding of an angle at the rim of the given ones does not count.
        inside = (gamma >= self.gamma[0] - 1e-9) & (gamma <= self.gamma[-1] + 1e-9)
        return np.where(inside, (shares * corners).sum(axis=1), 0.0)

    @property
    def lumens(self) -> float:
        """Luminous flux: the exact integral of the interpolated intensity over all directions."""
        gamma = np.radians(self.gamma)
        low, high = gamma[:-1], gamma[1:]
        # The integrals of sin and of the two linear functions times sin over each interval.
        whole = np.cos(low) - np.cos(high)
        upper = ((np.sin(high) - high * np.cos(high)) - (np.sin(low) - low * np.cos(low)) - low * whole) / (high - low)
        planes = self.candela[:, :-1] @ (whole - upper) + self.candela[:, 1:] @ upper
        if len(self.planes) == 1:
            return float(2 * np.pi * planes[0])
        return float(np.radians(np.diff(self.planes)) @ (planes[:-1] + planes[1:]) / 2)


def _between(knots, values):
    """The interval of each value, and the value's place in it, 0 to 1."""
    if len(knots) == 1:
        return np.zeros(len(values), dtype=np.intp), np.zeros(len(values))
    index = np.clip(np.searchsorted(knots, values, side="right") - 1, 0, len(knots) - 2)
    return index, np.clip((values - knots[index]) / (knots[index + 1] - knots[index]), 0, 1)
