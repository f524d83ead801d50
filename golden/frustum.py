"""Bundles of rays that leave one point: hemispheres for form factors, screens for images."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from golden.cast.rays import Rays
from golden.errors import InputError
from golden.scene.camera import Camera

__all__ = ["Hemisphere", "Screen", "frame"]

# The least and the largest number of rays around and down a hemisphere.
_GRID = (4, 4096)

# The normal whose frame is the starting point of all others: oblique, so that the frames' one discontinuity stays away
# from the normals that buildings have.
_POLE = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
_AXIS_0 = np.array([2.0, -1.0, 0.0]) / np.sqrt(5.0)
_AXIS_90 = np.cross(_POLE, _AXIS_0)


def frame(normals) -> np.ndarray:
    """Local axes for unit normals.

    The rotation that takes an oblique pole to the normal the short way carries the pole's axes along, so equal normals
    have equal frames, and near normals near frames but for a circle of normals 26 degrees around the pole's opposite.

    Parameters
    ----------
    normals
        M x 3 unit vectors (or one vector of 3).

    Returns
    -------
    M x 3 x 3 (or 3 x 3): rows are the axis of azimuth 0, the axis of azimuth 90 degrees, and the normal; right-handed.
    A local direction ``d`` is ``d @ frame`` in the scene.
    """
    normals = np.asarray(normals, dtype=np.float64)
    cosine = normals @ _POLE
    # Near the pole's opposite the short way is ill-defined: start there from the pole turned over about axis 0.
    side = np.where(cosine < -0.9, -1.0, 1.0)
    start = np.stack(np.broadcast_arrays(_AXIS_0, side[..., None] * _AXIS_90), axis=-2)
    middle = side[..., None] * _POLE + normals
    along = np.einsum("...ij,...j->...i", start, normals) / (1.0 + side * cosine)[..., None]
    return np.concatenate([start - along[..., None] * middle[..., None, :], normals[..., None, :]], axis=-2)


@dataclass(frozen=True)
class Hemisphere:
    """A grid of ``azimuths`` x ``polars`` directions over a hemisphere, one through the centre of each cell.

    Ray ``polar * azimuths + azimuth`` has the angles ``(2 polar + 1) (pi/2) / (2 polars)`` from the normal and
    ``(2 azimuth + 1) (2 pi) / (2 azimuths)`` around it. Its weight is the exact form factor of its cell as an integer
    number of 2^-``weight_bits``: all weights of a hemisphere sum to 2^``weight_bits`` exactly, and each is within one
    unit of its cell's integral.

    Parameters
    ----------
    azimuths, polars
        Powers of two from 4 to 4096.

    Errors
    ------
    InputError
        A number of rays that is no power of two or out of range.

    Source: Shen 1993, section 2.2.1 and Eq. 3.4.
    """

    azimuths: int
    polars: int

    def __post_init__(self):
        for name in ("azimuths", "polars"):
            value = getattr(self, name)
            if not isinstance(value, (int, np.integer)) or isinstance(value, bool) \
                    or not _GRID[0] <= value <= _GRID[1] or value & (value - 1):
                raise InputError(f"hemisphere: {name.capitalize()} must be a power of two "
                                 f"from {_GRID[0]} to {_GRID[1]}, not {value!r}")

    def __len__(self) -> int:
        return self.azimuths * self.polars

    @property
    def weight_bits(self) -> int:
        """W: the weights are in units of 2^-W."""
        return 40 if self.azimuths >= 2048 else 32

    @cached_property
    def polar_weights(self) -> np.ndarray:
        """``polars`` int64: the weight of one ray of each polar index."""
        borders = np.arange(self.polars + 1) * (np.pi / 2 / self.polars)
        share = np.sin(borders) ** 2
        cumulative = np.rint(share * (2**self.weight_bits // self.azimuths)).astype(np.int64)
        return np.diff(cumulative)

    @cached_property
    def directions(self) -> np.ndarray:
        """R x 3 unit vectors (sin p cos a, sin p sin a, cos p) in the local frame."""
        polar = (2 * np.arange(self.polars) + 1) * (np.pi / 4 / self.polars)
        azimuth = (2 * np.arange(self.azimuths) + 1) * (np.pi / self.azimuths)
        table = np.empty((self.polars, self.azimuths, 3))
        table[..., 0] = np.sin(polar)[:, None] * np.cos(azimuth)
        table[..., 1] = np.sin(polar)[:, None] * np.sin(azimuth)
        table[..., 2] = np.cos(polar)[:, None]
        return table.reshape(-1, 3)

    @cached_property
    def weights(self) -> np.ndarray:
        """R int64: the weight of each ray."""
        return np.repeat(self.polar_weights, self.azimuths)


@dataclass(frozen=True, kw_only=True)
class Screen:
    """The pixels of an image as rays from a camera's eye.

    In the camera's axes (right, up, forward) the ray through a pixel is (x, y, 1), so that ``t`` of its hit is the
    depth along the view.

    Parameters
    ----------
    camera
        Eye, view and vertical field of view.
    width, height
        Pixels, 1 to 65536 each.

    Errors
    ------
    InputError
        A size out of range.
    """

    camera: Camera
    width: int
    height: int

    def __post_init__(self):
        for name in ("width", "height"):
            value = getattr(self, name)
            if not isinstance(value, (int, np.integer)) or isinstance(value, bool) or not 1 <= value <= 65536:
                raise InputError(f"screen: {name.capitalize()} must be 1 to 65536 pixels, not {value!r}")

    def __len__(self) -> int:
        return self.width * self.height

    @property
    def pitch(self) -> float:
        """Width and height of a pixel at depth 1."""
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
            R x 2, where in its pixel each ray passes: right and down of the centre, in pixels (-0.5 to 0.5 stays
            inside). Default: the centre.

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
