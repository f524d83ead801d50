"""The pinhole camera of a scene."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError

__all__ = ["Camera"]

LARGEST = 1e30
"""Largest coordinate: squares and products of such are finite."""


@dataclass(frozen=True, kw_only=True)
class Camera:
    """A pinhole at ``eye`` that looks at ``target``; pixel (0, 0) is the upper left one.

    Parameters
    ----------
    eye, target, up
        Points and direction in scene units. ``up`` need not be orthogonal to the view, but must not be along it.
    fov
        Full vertical field of view in degrees, between 0 and 180 exclusive. The horizontal one follows from the
        picture's aspect; pixels are square.

    Raises
    ------
    InputError
        The camera is degenerate: eye and target coincide, ``up`` is zero or along the view, a value is not finite
        or beyond `LARGEST`, or the field of view is outside its range.
    """

    eye: tuple[float, float, float]
    target: tuple[float, float, float]
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    fov: float = 40.0

    def __post_init__(self):
        for name in ("eye", "target", "up"):
            value = tuple(float(coordinate) for coordinate in getattr(self, name))
            if len(value) != 3 or not np.all(np.abs(value) <= LARGEST):
                raise InputError(f"camera: {name.capitalize()} must be three finite coordinates up to {LARGEST:g}, "
                                 f"not {value!r}", parameter=name)
            object.__setattr__(self, name, value)
        if not np.isfinite(self.fov) or not 0 < self.fov < 180:
            raise InputError(f"camera: Field of view must be between 0 and 180 degrees, not {self.fov!r}",
                             parameter="fov")
        view = np.subtract(self.target, self.eye)
        if not np.linalg.norm(view) > 0:
            raise InputError(f"camera: Target must be away from the eye, not at {self.eye!r} as well",
                             parameter="target")
        if not np.linalg.norm(np.cross(view, self.up)) > 1e-9 * np.linalg.norm(view) * np.linalg.norm(self.up):
            raise InputError(f"camera: Up must not be zero or along the view, not {self.up!r}", parameter="up")

    @property
    def axes(self) -> np.ndarray:
        """Right, up and forward unit vectors as the rows of a 3 x 3 matrix."""
        forward = np.subtract(self.target, self.eye)
        forward = forward / np.linalg.norm(forward)
        right = np.cross(forward, self.up)
        right = right / np.linalg.norm(right)
        return np.array([right, np.cross(right, forward), forward])
