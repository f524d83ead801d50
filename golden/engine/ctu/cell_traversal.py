"""Cell traversal: integer digital differential analysis (DDA) of many grid rays at once, in units of a cell.

A ray starts at the inner border of its shell. Parameters count from there, so they are short, and a step compares and
adds integers. The one division is a reciprocal per axis when a ray starts.

Source: Shen 1993, section 5.3.4.5; Shen & Deprettere, cell traversal with ties on several axes at once.
"""

import numpy as np

from golden.engine.ctu.grid_rays import FRACTION

__all__ = ["BEGIN_BITS", "INDEX_BITS", "NEVER", "PARAMETER_BITS", "POSITION_FRACTION", "RECIPROCAL_BITS", "Traversal",
           "reciprocal", "reciprocal_table", "traversal_start"]

# Bits of a reciprocal's mantissa and of the magnitude that it inverts; the leading ROW_BITS select the table's row.
RECIPROCAL_BITS = 20
ROW_BITS = 9
# Guard bits of a table's value below those of the mantissa.
GUARD = 3
# Fraction bits of positions and parameters, both in cells.
POSITION_FRACTION = 16
# Bits of a cell's signed index along an axis; a ray beyond that range never returns to the grid.
INDEX_BITS = 13
# Bits of a parameter within a shell, and of the parameter at which a shell begins.
PARAMETER_BITS = 10 + POSITION_FRACTION
BEGIN_BITS = 14 + POSITION_FRACTION
# A parameter that no ray reaches within its shell.
NEVER = (1 << PARAMETER_BITS) - 1


def reciprocal_table():
    """Value and slope of each row of the table of `reciprocal`: 2^ROW_BITS int64 each.

    A chord of 1/x is above 1/x by at most an eighth of the row's squared width times the second derivative. A row's
    value is lowered by half of that, and raised by half a unit of the mantissa, since the guard bits are truncated.
    """
    rows = 1 << ROW_BITS
    ends = 2.0 ** (RECIPROCAL_BITS + GUARD) / (1 + np.arange(rows + 1) / rows)
    sag = ends[:-1] / (1 + np.arange(rows) / rows) ** 2 / (8.0 * rows * rows)
    value = np.floor(ends[:-1] - sag + 0.5 * (1 << GUARD)).astype(np.int64)
    return value, np.rint(ends[:-1] - ends[1:]).astype(np.int64)


_VALUE, _SLOPE = reciprocal_table()


def reciprocal(magnitude: np.ndarray):
    """``mantissa`` and ``shift`` with ``2^FRACTION / magnitude ~ mantissa / 2^shift``, within 1.2 units of it,
    and of powers of two exactly, for magnitudes from 1 to 2^RECIPROCAL_BITS - 1.

    Mantissas are from ``2^(RECIPROCAL_BITS - 1)`` to ``2^RECIPROCAL_BITS``.
    """
    length = np.frexp(magnitude.astype(np.float64))[1].astype(np.int64)
    normal = magnitude << (RECIPROCAL_BITS - length)
    rest = RECIPROCAL_BITS - 1 - ROW_BITS
    row, offset = (normal >> rest) - (1 << ROW_BITS), normal & (1 << rest) - 1
    return _VALUE[row] - (_SLOPE[row] * offset >> rest) >> GUARD, RECIPROCAL_BITS - 1 + length - FRACTION


def traversal_start(origin: np.ndarray, direction: np.ndarray, begin: np.ndarray):
    """Where K grid rays are at the parameter ``begin``, and how far the next cell borders are.

    Parameters
    ----------
    origin, direction
        As of `Traversal`.
    begin
        K x 1 int64, or one for all: where the shell begins.

    Returns
    -------
    K x 3 int64 each: the cell; the parameter, from ``begin`` on, of the next border on each axis; and that from one
    border to the next. Both are at most `NEVER`, which they are on an axis along which a ray does not move.
    """
    position = np.asarray(origin) + (direction * begin >> FRACTION)
    mantissa, shift = reciprocal(np.maximum(np.abs(direction), 1))
    within = position & (1 << POSITION_FRACTION) - 1
    # A ray of negative direction may start on its next border.
    distance = np.where(direction > 0, (1 << POSITION_FRACTION) - within, within)
    next_, between = (np.where(direction == 0, NEVER, np.minimum(length * mantissa >> shift, NEVER))
                      for length in (distance, 1 << POSITION_FRACTION))
    return position >> POSITION_FRACTION, next_, between


class Traversal:
    """Grid rays of one shell in traversal.

    Parameters
    ----------
    origin
        3 int64, in units of 2^-POSITION_FRACTION cells from the grid's lower corner, see `CellTable.position`.
    direction
        K x 3 int64 in units of 2^-FRACTION, below 2^RECIPROCAL_BITS in magnitude.
    begin, end
        The shell: parameters in units of 2^-POSITION_FRACTION cells, at most `NEVER` apart.
    shape
        Cells along x, y and z.

    Members
    -------
    ray
        M int64, numbers of the rays in traversal.
    index
        M x 3 int64, the cell of each ray. A ray may start outside the grid and enter it later.

    Raises
    ------
    ValueError
        Begin or end is out of range.
    """

    def __init__(self, origin, direction, *, begin: int, end: int, shape):
        if not 0 <= begin < 1 << BEGIN_BITS or not 0 <= end - begin <= NEVER:
            raise ValueError(f"Begin and end must be below 2^{BEGIN_BITS} and at most {NEVER} apart, not {begin!r} and "
                             f"{end!r}")
        self._length, self._shape = end - begin, np.asarray(shape)
        self.ray, self._step = np.arange(len(direction)), np.sign(direction)
        self.index, self._next, self._between = traversal_start(origin, direction, begin)
        self._drop(np.ones(len(direction), dtype=bool))

    @property
    def inside(self) -> np.ndarray:
        """M bool: the cell is one of the grid."""
        return ((self.index >= 0) & (self.index < self._shape)).all(axis=1)

    def advance(self) -> None:
        """One step of every ray; rays that pass the shell's outer border or leave the grid are dropped."""
        nearest = self._next.min(axis=1)
        crossed = self._next == nearest[:, None]
        self.index += self._step * crossed
        self._next = np.minimum(self._next + self._between * crossed, NEVER)
        self._drop(nearest < self._length)

    def _drop(self, keep):
        """Keep these rays, less those that can no longer enter the grid."""
        away = ((self.index < 0) & (self._step <= 0)) | ((self.index >= self._shape) & (self._step >= 0))
        far = np.abs(2 * self.index + 1) > 1 << INDEX_BITS
        keep = keep & ~(away | far).any(axis=1)
        self.ray, self.index, self._step, self._next, self._between = (
            value[keep] for value in (self.ray, self.index, self._step, self._next, self._between))
