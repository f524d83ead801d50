import numpy as np
import pytest

from benchmarks.view_factor_cases import BARRIER
from golden.light.factors.coincident_fronts import CoincidentFronts
from golden.light.factors.sides import Sides
from tb.golden.light.factors.rows import rows_of
from tb.golden.light.scenes import BLACK, rectangle, scene_of

# Fronts to +x; back to back with it one of twice its width, one beside it; one in front of it; one with its normal.
WALL = rectangle((0, 0, 0), (0, 1, 0), (0, 0, 1))
OTHERS = (rectangle((0, 0, 0), (0, 0, 1), (0, 2, 0)), rectangle((0, 2, 0), (0, 0, 1), (0, 1, 0)),
          rectangle((0.1, 0, 0), (0, 0, 1), (0, 1, 0)), rectangle((0, 0, 0), (0, 1, 0), (0, 0, 1)))


def met(patches, y, two_sided=False):
    fronts = CoincidentFronts(Sides(scene_of(([WALL], BLACK), (patches, BLACK, {"two_sided": two_sided}))))
    y = np.array(y, dtype=float)
    origin = np.stack([np.full(len(y), -1.0), y, np.full(len(y), 0.25)], axis=1)
    return fronts.met(np.zeros(len(y), int), origin, np.tile([1.0, 0, 0], (len(y), 1)))


def test_a_ray_meets_the_front_at_the_back_that_it_hits():
    np.testing.assert_array_equal(met(OTHERS[:1], [0.3, 0.9]), [1, 1])


@pytest.mark.parametrize("number", [1, 2, 3])
def test_patches_beside_before_and_with_the_same_front_are_not_met(number):
    np.testing.assert_array_equal(met([OTHERS[number]], [0.3, 0.9]), [-1, -1])


def test_each_ray_meets_the_front_at_its_point():
    halves = [rectangle((0, low, 0), (0, 0, 1), (0, 0.4, 0)) for low in (0, 0.5)]
    np.testing.assert_array_equal(met(halves, [0.2, 0.45, 0.7, 0.95]), [1, -1, 2, -1])


def test_the_back_of_a_two_sided_patch_is_a_front():
    np.testing.assert_array_equal(met([OTHERS[3]], [0.3], two_sided=True), [2])


@pytest.mark.parametrize("seed", [0, 1])
def test_rows_at_a_wall_of_two_patches_back_to_back_close(seed):
    rows = rows_of(scene_of((BARRIER().facets, BLACK)), error=1e-2, seed=seed)
    found = rows.join([rows.rows(0, len(rows))])
    assert found.closure <= 1e-9
    assert not len(found.infeasible)
