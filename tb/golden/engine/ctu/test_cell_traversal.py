"""Grid rays visit the cells that exact arithmetic finds."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

from golden.engine.ctu.cell_traversal import POSITION_FRACTION, RECIPROCAL_BITS, Traversal, reciprocal
from golden.engine.ctu.grid_rays import FRACTION

ONE = 1 << FRACTION
CELL = 1 << POSITION_FRACTION
# Largest displacement of a position by rounding.
WITHIN = CELL >> 11


def walk(origin, direction, *, begin=0, end=64 * CELL, shape=(8, 8, 8)):
    """Cells of one ray, in order."""
    rays = Traversal(np.array(origin), np.array([direction]), begin=begin, end=end, shape=np.array(shape))
    cells = []
    while len(rays.ray):
        if rays.inside[0]:
            cells.append(tuple(int(i) for i in rays.index[0]))
        rays.advance()
    return cells


def visited(origin, direction, begin, end, shape, *, within):
    """Cells that the ray enters by more than ``within``, exactly."""
    found = set()
    for index in np.ndindex(*shape):
        low, high = Fraction(int(begin)), Fraction(int(end))
        for axis in range(3):
            lower, upper = index[axis] * CELL + within, (index[axis] + 1) * CELL - within
            if direction[axis] == 0:
                if not lower <= origin[axis] < upper:
                    high = Fraction(-1)
                continue
            crossings = sorted(Fraction(int(plane - origin[axis]) * ONE, int(direction[axis]))
                               for plane in (lower, upper))
            low, high = max(low, crossings[0]), min(high, crossings[1])
        if low < high:
            found.add(index)
    return found


def test_the_reference_sequences_of_the_paper():
    half, quarter = CELL // 2, CELL // 4
    # A third is rounded, so that of the axes that are crossed at once one may be first by a cell of no length.
    cells = iter(walk((half,) * 3, (3 * 2048, 2 * 2048, 2048), shape=(5, 5, 5)))
    for expected in (0, 0, 0), (1, 0, 0), (1, 1, 0), (2, 1, 1), (2, 2, 1), (3, 2, 1), (4, 2, 1):
        assert expected in cells
    assert walk((half,) * 3, (ONE, ONE, 0), shape=(4, 4, 4)) == [(0, 0, 0), (1, 1, 0), (2, 2, 0), (3, 3, 0)]
    assert walk((quarter, half, half + 3 * CELL), (ONE, 0, -ONE))[:5] == [
        (0, 0, 3), (0, 0, 2), (1, 0, 2), (1, 0, 1), (2, 0, 1)]


@pytest.mark.parametrize("seed", range(40))
def test_a_ray_visits_every_cell_that_it_enters_clearly_and_no_cell_that_it_clearly_misses(seed):
    random = np.random.default_rng(seed)
    shape = random.integers(1, 6, 3)
    origin = random.integers(-CELL, (shape + 1) * CELL)
    direction = np.rint(random.normal(size=3) * ONE / 2).astype(np.int64)
    if seed % 3 == 0:
        direction[random.integers(3)] = random.integers(-2, 3)
    if not direction.any():
        direction[0] = 1
    begin = int(random.integers(0, 3 * CELL))
    end = begin + int(random.integers(CELL // 2, 6 * CELL))
    cells = set(walk(origin, direction, begin=begin, end=end, shape=shape))
    assert cells >= visited(origin, direction, begin, end, shape, within=WITHIN)
    assert cells <= visited(origin, direction, begin - WITHIN, end, shape, within=-WITHIN)


def test_a_ray_ends_at_the_shell_border_and_goes_on_from_there_in_the_next_shell():
    direction = (ONE * 3 // 5, ONE * 4 // 5, 100)
    cells = [walk((CELL // 3,) * 3, direction, begin=k * CELL, end=(k + 1) * CELL) for k in range(5)]
    for first, second in pairwise(cells):
        assert first[-1] == second[0] or sum(abs(a - b) for a, b in zip(first[-1], second[0], strict=True)) == 1
    assert [cell for part in cells for cell in part if part] != []


@pytest.mark.parametrize("axis", range(3))
def test_a_ray_that_starts_outside_enters_at_the_border_or_not_at_all(axis):
    origin = np.full(3, CELL // 2)
    origin[axis] = -3 * CELL
    direction = np.zeros(3, dtype=np.int64)
    direction[axis] = ONE
    assert len(walk(origin, direction)) == 8
    assert len(walk(origin, direction, end=3 * CELL - WITHIN)) == 0
    assert len(walk(origin, direction, begin=5 * CELL, end=6 * CELL)) == 1
    assert walk(origin, -direction) == []


def test_reciprocals_are_nearly_within_one_unit_of_their_last_place():
    magnitude = np.concatenate([np.arange(1, 5000), (1 << np.arange(RECIPROCAL_BITS)),
                                np.arange(1 << RECIPROCAL_BITS - 1, 1 << RECIPROCAL_BITS)])
    mantissa, shift = reciprocal(magnitude)
    assert ((mantissa >= 1 << RECIPROCAL_BITS - 1) & (mantissa <= 1 << RECIPROCAL_BITS)).all()
    exact = 2.0**FRACTION / magnitude
    given = mantissa / 2.0**shift
    assert (np.abs(exact - given) < 1.2 * 2.0**-shift).all()
    assert (exact == given)[magnitude & magnitude - 1 == 0].all()
