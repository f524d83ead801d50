"""Where rays of hemispheres are cast again, finer, and the grids of the finer ones."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import whole_number
from golden.cast.hemisphere import Hemisphere

__all__ = ["MOST_AXIS", "Density", "Level"]

MOST_AXIS = 4096
"""Azimuths, and polar angles, of the finest grid."""


@dataclass(frozen=True, kw_only=True)
class Density:
    """Where rays are cast again.

    Parameters
    ----------
    least
        Rays that should meet a patch, 1 to 4096: the cells around one that fewer meet are cast again.
    levels
        Most times that a cell is, 1 to 10; no grid has more than `MOST_AXIS` azimuths or polar angles.

    Raises
    ------
    InputError
        A value is out of range.
    """

    least: int
    levels: int = 10

    def __post_init__(self):
        for name, most in (("least", 4096), ("levels", 10)):
            whole_number(f"density: {name.capitalize()}", getattr(self, name), 1, most, parameter=name)

    def depth(self, hemisphere: Hemisphere) -> int:
        """Levels below those of a hemisphere's grid."""
        return min(self.levels, (MOST_AXIS // max(hemisphere.azimuths, hemisphere.polars)).bit_length() - 1)


@dataclass(frozen=True, eq=False)
class Level:
    """A grid with 2^``level`` times the azimuths and polar angles of a hemisphere, whose cells it divides.

    Its weights are in units of 2^-(W + level), W the hemisphere's ``weight_bits``: those of the four cells of a coarser
    cell sum to its own, exactly.
    """

    hemisphere: Hemisphere
    level: int

    @property
    def grid(self) -> Hemisphere:
        """The grid of rays, with weights of its own."""
        return Hemisphere(self.hemisphere.azimuths << self.level, self.hemisphere.polars << self.level)

    @property
    def row_weights(self) -> np.ndarray:
        """Int64: the weight of one ray of each row."""
        count = self.hemisphere.polars << self.level
        share = np.sin(np.arange(count + 1) * (np.pi / 2 / count)) ** 2
        return np.diff(np.rint(share * (2**self.hemisphere.weight_bits // self.hemisphere.azimuths)).astype(np.int64))

    def directions(self, column: np.ndarray, row: np.ndarray) -> np.ndarray:
        """K x 3 unit vectors in the local frame."""
        grid = self.grid
        polar, azimuth = (2 * row + 1) * (np.pi / 4 / grid.polars), (2 * column + 1) * (np.pi / grid.azimuths)
        return np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=1)
