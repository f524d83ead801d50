"""From cell to cell along many grid rays at once: integer digital differential analysis in G coordinates.

A ray's parameter is in units of G for a direction of 1, so a step compares and adds integers only. The one division is
a reciprocal per axis when a ray starts.

Source: Shen 1993, section 5.3.4.5; Shen & Deprettere, cell traversal with ties on several axes at once.
"""

import numpy as np

from golden.ctu.grid_rays import FRACTION

__all__ = ["NEVER", "RECIPROCAL_BITS", "Traversal", "reciprocal"]

# Bits of a reciprocal's mantissa.
RECIPROCAL_BITS = 20
# A parameter that no ray reaches: 2^12 times the unit cube.
NEVER = 1 << 36


def reciprocal(magnitude: np.ndarray):
    """``mantissa`` and ``shift`` with ``2^FRACTION / magnitude ~ mantissa / 2^shift``, truncated,
    for magnitudes from 1.

    Mantissas are from ``2^(RECIPROCAL_BITS - 1)`` to ``2^RECIPROCAL_BITS``.
    """
    length = np.frexp(magnitude.astype(np.float64))[1].astype(np.int64)
    normal = magnitude << (RECIPROCAL_BITS - length)
    return (1 << 2 * RECIPROCAL_BITS - 1) // normal, RECIPROCAL_BITS - 1 + length - FRACTION


class Traversal:
    """Grid rays of one shell on their way through the cells.

    Parameters
    ----------
    origin
        3 int64, G.
    direction
        K x 3 int64 in units of 2^-FRACTION, below 2^RECIPROCAL_BITS in magnitude.
    begin, end
        The shell: parameters in units of G.
    lower, cell, shape
        The grid, see `CellTable`.

    Members
    -------
    ray
        Numbers of the rays under way.
    index
        M x 3 int64, the cell of each.
    """

    def __init__(self, origin, direction, *, begin: int, end: int, lower, cell: int, shape):
        self._end, self._shape = end, np.asarray(shape)
        lines = _Lines(np.asarray(origin), direction)
        lower = np.asarray(lower)
        upper = lower + cell * self._shape
        enter, leave = lines.crossing(np.where(lines.forward, lower, upper), never=-NEVER), lines.crossing(
            np.where(lines.forward, upper, lower), never=NEVER)
        outside = (lines.still & ((origin < lower) | (origin >= upper))).any(axis=1)
        start = np.maximum(enter.max(axis=1), begin)
        self.ray = np.flatnonzero((start < np.minimum(leave.min(axis=1), end)) & ~outside)
        lines, start = _Lines(lines.origin, direction[self.ray]), start[self.ray, None]
        point = lines.origin + (lines.direction * start >> FRACTION)
        self.index = np.clip((point - lower) // cell, 0, self._shape - 1)
        self._next = np.maximum(lines.crossing(lower + (self.index + lines.forward) * cell, never=NEVER), start)
        self._between = np.minimum(cell * lines.mantissa >> lines.shift, NEVER)
        self._step = np.sign(lines.direction)

    def advance(self) -> None:
        """One step of every ray: those that pass the shell's or the grid's border are done."""
        nearest = self._next.min(axis=1)
        crossed = self._next == nearest[:, None]
        self.index += self._step * crossed
        self._next += self._between * crossed
        keep = (nearest < self._end) & ((self.index >= 0) & (self.index < self._shape)).all(axis=1)
        self.ray, self.index, self._next, self._between, self._step = (
            value[keep] for value in (self.ray, self.index, self._next, self._between, self._step))


class _Lines:
    """Rays with the reciprocals of their directions."""

    def __init__(self, origin, direction):
        self.origin, self.direction = origin, direction
        self.forward, self.still = direction > 0, direction == 0
        self.mantissa, self.shift = reciprocal(np.maximum(np.abs(direction), 1))

    def crossing(self, plane, *, never):
        """Parameters at which the rays cross planes, one for each axis, rounded towards 0; ``never`` if along them."""
        distance = np.where(self.forward, plane - self.origin, self.origin - plane)
        passed = np.sign(distance) * (np.abs(distance) * self.mantissa >> self.shift)
        return np.where(self.still, never, np.clip(passed, -NEVER, NEVER))
