"""The pixels of a picture as rays."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from golden.base.errors import InputError, check_int
from golden.cast.rays import Rays
from golden.scene.camera import Camera

__all__ = ["Screen"]


@dataclass(frozen=True, kw_only=True)
class Screen:
    """The pixels of a picture as rays from a camera's eye.

    In the camera's axes (right, up, forward) the ray through a pixel is (x, y, 1), so ``t`` of its hit is the depth
    along the view.

    Parameters
    ----------
    camera
        Eye, view and vertical field of view.
    width, height
        Pixels, 1 to 65536 each.

    Raises
    ------
    InputError
        A size is out of range.
    TypeError
        A size is no int.
    """

    camera: Camera
    width: int
    height: int

    def __post_init__(self):
        for name in ("width", "height"):
            value = getattr(self, name)
            check_int(f"screen: {name.capitalize()}", value)
            if not 1 <= value <= 65536:
                raise InputError(f"screen: {name.capitalize()} must be 1 to 65536 pixels, not {value!r}",
                                 parameter=name)

    def __len__(self) -> int:
        return self.width * self.height

    @property
    def pitch(self) -> float:
        """Width and height of a pixel at depth 1, in scene units."""
        return 2.0 * float(np.tan(np.radians(self.camera.fov) / 2)) / self.height

    @cached_property
    def x(self) -> np.ndarray:
        """``width`` values: the pixel centres' x at depth 1, left to right."""
        return (np.arange(self.width) - (self.width - 1) / 2) * self.pitch

    @cached_property
    def y(self) -> np.ndarray:
        """``height`` values: the pixel centres' y at depth 1, top to bottom."""
        return ((self.height - 1) / 2 - np.arange(self.height)) * self.pitch

    def rays(self, pixels=None, offsets=None) -> Rays:
        """Primary rays.

        Parameters
        ----------
        pixels
            R numbers ``row * width + column``, row 0 on top. Default: all pixels in that order.
        offsets
            R x 2 float64, offset of each ray from the centre of its pixel: right and down, in pixels; -0.5 to 0.5 is
            inside. Default: 0.

        Returns
        -------
        R rays from the eye with directions in the scene, not of unit length (see above).
        """
        pixels = np.arange(len(self)) if pixels is None else np.asarray(pixels)
        row, column = np.divmod(pixels, self.width)
        local = np.stack([self.x[column], self.y[row], np.ones(len(pixels))], axis=1)
        if offsets is not None:
            local[:, :2] += np.asarray(offsets, dtype=np.float64) * (self.pitch, -self.pitch)
        return Rays(np.broadcast_to(np.array(self.camera.eye), local.shape), local @ self.camera.axes)
