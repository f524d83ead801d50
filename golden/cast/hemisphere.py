"""Hemispheres of rays for form factors."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from golden.base.errors import InputError, check_int

__all__ = ["Hemisphere"]

# Least and largest number of azimuths, and of polar angles.
_GRID = (4, 4096)


@dataclass(frozen=True)
class Hemisphere:
    """A grid of ``azimuths`` x ``polars`` directions over a hemisphere, one through the centre of each cell.

    Ray ``polar * azimuths + azimuth`` has the angles ``(2 polar + 1) (pi/2) / (2 polars)`` from the normal and
    ``(2 azimuth + 1) (2 pi) / (2 azimuths)`` around it. Its weight is the exact form factor of its cell as an integer
    number of 2^-``weight_bits``: all weights of a hemisphere sum to 2^``weight_bits`` exactly, and each is within one
    unit of its cell's integral (docs/exactness.md).

    Parameters
    ----------
    azimuths, polars
        Powers of two from 4 to 4096.

    Raises
    ------
    InputError
        A number of rays is no power of two or out of range.
    TypeError
        A number of rays is no int.

    Source: Shen 1993, section 2.2.1 and Eq. 3.4.
    """

    azimuths: int
    polars: int

    def __post_init__(self):
        for name in ("azimuths", "polars"):
            value = getattr(self, name)
            check_int(f"hemisphere: {name.capitalize()}", value)
            if not _GRID[0] <= value <= _GRID[1] or value & (value - 1):
                raise InputError(f"hemisphere: {name.capitalize()} must be a power of two "
                                 f"from {_GRID[0]} to {_GRID[1]}, not {value!r}", parameter=name)

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
