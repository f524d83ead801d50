"""How far around a grid ray hits may lie: the radii that keep shelling exact.

A hit P of an intersection ray lies in a cell whose centre C is within half a cell diagonal of P. The grid ray that
opens this cell in C's shell passes within half a cell of C, at C's own distance (of a screen: depth). Everything below
follows from these two lengths. Lengths are in cells; shell s lies between the distances s - 1 and s.

Source: docs/exactness.md, Shelling.
"""

import numpy as np

__all__ = ["DIAGONAL", "RADIUS", "angle", "azimuth_reach", "depth", "horizon", "screen_border", "screen_reach",
           "screen_sector_reach", "sector_angle", "sector_reach", "slack"]

# Half a diagonal of a cell, and the radius of the ball inside it.
DIAGONAL = np.sqrt(3) / 2
RADIUS = 0.5


def slack(shell: int, stretch: float = 1.0) -> float:
    """What rounding moves a hit, a grid ray or a cell border in this shell.

    Directions are off by less than 2^-13 of a grid ray's parameter, which is ``stretch`` times the distance or depth:
    tables, matrix and direction are rounded to 16 fraction bits, at most 12 times half a unit together, and vertices
    are normalised. Start points, steps and distances are off by less than 2^-10 of a cell.
    """
    return 2.0**-10 + shell * stretch * 2.0**-13


def depth(shell: int) -> float:
    """How much nearer than the shell's inner border a hit in a cell of this shell may be."""
    return DIAGONAL + slack(shell)


def angle(shell: int) -> float:
    """psi: the largest angle between a hit in a cell of this shell and the grid ray that opens the cell."""
    return _angle(DIAGONAL + RADIUS + slack(shell), shell)


def horizon(shell: int) -> float:
    """How far below the horizon a cell's centre may lie that holds a hit above it."""
    return min(_angle(DIAGONAL + slack(shell), shell), np.pi / 2)


def azimuth_reach(psi: float, polar: np.ndarray) -> np.ndarray:
    """Half the azimuth span of the cap of angle ``psi`` around directions at the angle ``polar`` from the normal."""
    inside = (polar > psi) & (np.pi - polar > psi)
    return np.where(inside, np.arcsin(np.sin(psi) / np.sin(np.where(inside, polar, np.pi / 2)) * inside), np.pi)


# A sector's grid rays go as far past its border as its intersection rays can need them.
sector_angle = angle
sector_reach = azimuth_reach


def screen_border(shell: int, half: float, stretch: float) -> float:
    """How far beyond a screen's border, as a slope, the centre of a cell may lie that holds a hit on the screen.

    ``half`` is the slope of the border itself; the hit may be half a diagonal from the centre, and its depth too.
    """
    return (DIAGONAL + slack(shell, stretch)) * np.sqrt(1 + half * half) / (shell - 1)


def screen_reach(shell: int, half: float, step: float, stretch: float) -> float:
    """How far apart the slopes of a hit in a cell and of the grid ray that opens the cell may be, in x as in y.

    ``step`` is the distance between grid rays.
    """
    return (DIAGONAL + slack(shell, stretch)) * np.sqrt(1 + half * half) / (shell - 1) + step / 2


screen_sector_reach = screen_reach


def _angle(distance, shell):
    return np.arcsin(distance / (shell - 1)) if distance < shell - 1 else np.pi
