"""Margins that keep shelling exact: how far from a grid ray the hits may be that it represents.

A hit P of an intersection ray is in a cell whose centre C is within half a cell diagonal of P. The grid ray that opens
this cell in C's shell passes within half a cell of C, at C's own distance (screen: depth). All margins follow from
these two lengths. Lengths are in cells; shell s is between the distances s - 1 and s.

Source: docs/exactness.md, Shelling.
"""

import numpy as np

from golden.engine.config import Numbers

__all__ = ["DEFAULT", "DIAGONAL", "RADIUS", "angle", "azimuth_reach", "depth", "horizon", "rounding", "screen_border",
           "screen_reach", "screen_sector_reach", "sector_angle", "sector_reach", "slack"]

# Half a diagonal of a cell, and the radius of its inscribed ball.
DIAGONAL = np.sqrt(3) / 2
RADIUS = 0.5


def rounding(numbers: Numbers, displacement: float = 0.0) -> tuple[float, float]:
    """By how much a format's rounding moves hits and grid rays: in cells, and as a share of a grid ray's parameter.

    With d fraction bits directions are off by less than 2^(2 - d) + 2^-14 of it. The two matrices are rounded to d,
    together at most 6 times half a unit; tables and direction of a grid ray to 16, at most as many times; and vertices
    are normalised. Start points, steps and distances are off by less than 2^-10 of a cell, with ``displacement``, that
    of a vertex beyond what its cells list, up to half of this.
    """
    return 2.0**-10 + max(0.0, displacement - 2.0**-11), 2.0**(2 - numbers.direction_fraction) + 2.0**-14


DEFAULT = rounding(Numbers())
"""Of the default formats."""


def slack(shell: int, slope_scale: float = 1.0, rounding: tuple[float, float] = DEFAULT) -> float:
    """Upper bound of the displacement of hits, grid rays and cell borders of a shell by `rounding`, in cells.

    A grid ray's parameter is ``slope_scale`` times the distance or depth.
    """
    fixed, share = rounding
    return fixed + shell * slope_scale * share


def depth(shell: int, rounding: tuple[float, float] = DEFAULT) -> float:
    """Largest distance of a hit in a cell of this shell from the shell's inner border, towards the origin, in cells."""
    return DIAGONAL + slack(shell, rounding=rounding)


def angle(shell: int, rounding: tuple[float, float] = DEFAULT) -> float:
    """psi: the largest angle between a hit in a cell of this shell and the grid ray that opens the cell, in radians."""
    return _angle(DIAGONAL + RADIUS + slack(shell, rounding=rounding), shell)


def horizon(shell: int, rounding: tuple[float, float] = DEFAULT) -> float:
    """Largest angle below the horizon of the centre of a cell that holds a hit above it, in radians."""
    return min(_angle(DIAGONAL + slack(shell, rounding=rounding), shell), np.pi / 2)


def azimuth_reach(psi: float, polar: np.ndarray) -> np.ndarray:
    """Half the azimuth span of the cap of angle ``psi`` around directions of the polar angle ``polar``, in radians."""
    inside = (polar > psi) & (np.pi - polar > psi)
    return np.where(inside, np.arcsin(np.sin(psi) / np.sin(np.where(inside, polar, np.pi / 2)) * inside), np.pi)


# A sector's grid rays extend past its border as far as its intersection rays need them.
sector_angle = angle
sector_reach = azimuth_reach


def screen_border(shell: int, half: float, slope_scale: float,
                  rounding: tuple[float, float] = DEFAULT) -> float:
    """Largest slope, beyond a screen's border, of the centre of a cell that holds a hit on the screen.

    ``half`` is the slope of the border itself. The hit may be half a diagonal from the centre, also in depth.
    """
    return (DIAGONAL + slack(shell, slope_scale, rounding)) * np.sqrt(1 + half * half) / (shell - 1)


def screen_reach(shell: int, half: float, step: float, slope_scale: float,
                 rounding: tuple[float, float] = DEFAULT) -> float:
    """Largest difference, in x and in y, of the slopes of a hit in a cell and of the grid ray that opens the cell.

    ``step`` is the spacing of the grid rays, as a slope.
    """
    return screen_border(shell, half, slope_scale, rounding) + step / 2


screen_sector_reach = screen_reach


def _angle(distance, shell):
    return np.arcsin(distance / (shell - 1)) if distance < shell - 1 else np.pi
