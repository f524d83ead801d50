import numpy as np
import pytest

from golden.light.factors.certain import certain_shares
from golden.light.factors.sides import Sides
from tb.golden.light.cube import cube
from tb.golden.light.scenes import BLACK, rectangle, scene_of

FLOOR = rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0))
CEILING = rectangle((0, 0, 1), (0, 1, 0), (1, 0, 0))


def shares(*patches):
    """Of the pair of the first two patches."""
    decided, share = certain_shares(Sides(scene_of(([*patches], BLACK))), np.array([0]), np.array([1]))
    return share[0] if decided[0] else None


def test_all_pairs_of_a_convex_room_see_each_other():
    sides = Sides(cube(2))
    first, second = np.divmod(np.arange(len(sides)**2), len(sides))
    facing = sides.surface[first] != sides.surface[second]
    decided, share = certain_shares(sides, first[facing], second[facing])
    assert decided.all()
    assert (share == 1).all()


@pytest.mark.parametrize(("blocker", "expected"), [
    (rectangle((0.2, 0.2, 0.5), (0.2, 0, 0), (0, 0.2, 0)), None),
    (rectangle((-1, -1, 0.5), (3, 0, 0), (0, 3, 0)), 0),
    (rectangle((0, 0, 0.5), (1, 0, 0), (0, 1, 0)), 0),
    (rectangle((-1, -1, 0.5), (3, 0, 0), (0, 1.99, 0)), None),
    (rectangle((1, 0, 0), (0, 1, 0), (0, 0, 1)), 1),
    (rectangle((2, 0, 0.2), (0, 1, 0), (1, 0, 0.3)), 1),
    (rectangle((0, 0, -1), (1, 0, 0), (0, 1, 0.9)), 1),
    (rectangle((0.5, 0.5, 0), (0.2, 0, 0), (0, 0, 0.3)), None),
], ids=["small between", "large between", "exact fit", "one edge short", "a wall", "outside", "below", "on the floor"])
def test_one_patch_beside_or_between(blocker, expected):
    assert shares(FLOOR, CEILING, blocker) == expected


def test_a_plane_through_an_edge_and_a_corner_separates():
    # The box around both contains the blocker, and so does none of their planes alone.
    low, high = rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), rectangle((4, 0, 1), (0, 1, 0), (1, 0, 0))
    above, between = (rectangle((1, 0.2, height), (0.5, 0, 0.1), (0, 0.5, 0)) for height in (0.3, 0.1))
    assert shares(low, high, above) == 1
    assert shares(low, high, between) is None


def test_two_patches_that_hide_together_decide_nothing():
    halves = [rectangle((-1 + 1.5 * k, -1, 0.5), (1.5, 0, 0), (0, 3, 0)) for k in range(2)]
    assert shares(FLOOR, CEILING, *halves) is None
