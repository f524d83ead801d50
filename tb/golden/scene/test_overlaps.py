from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.base.errors import InputWarning
from golden.scene.builtin import builtin_scene
from golden.scene.overlaps import overlaps, warn_of_overlaps
from tb.golden.light.scenes import BLACK, rectangle, scene_of
from tb.lib.schedules import SETTINGS


def square(x, y, z):
    return rectangle((x, y, z), (1, 0, 0), (0, 1, 0))


SQUARE = square(0, 0, 0)
RIGHT = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (1, 1, 0)], dtype=float)
LEFT = np.array([(0, 0, 0), (1, 1, 0), (0, 1, 0), (0, 1, 0)], dtype=float)


@st.composite
def rectangles(draw):
    """Up to six in two planes: borders west, east, south and north, height, whether front up, and whether two-sided."""
    found = []
    for _ in range(draw(st.integers(1, 6))):
        (west, east), (south, north) = (sorted(draw(st.sets(st.integers(0, 4), min_size=2, max_size=2)))
                                        for _ in range(2))
        found.append((west, east, south, north, draw(st.integers(0, 1)), draw(st.booleans()), draw(st.booleans())))
    return found


@settings(SETTINGS, max_examples=100)
@given(rectangles(), st.booleans(), st.lists(st.booleans(), min_size=6, max_size=6))
def test_pairs_that_overlap_in_any_plane_are_found_and_those_that_touch_are_not(given, is_turned, chosen):
    """If both face one way, or either faces both; of all pairs, or of those of a chosen and another patch."""
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0] if is_turned else np.eye(3)
    parts = [(rectangle((west, south, height), (east - west, 0, 0), (0, north - south, 0))[::1 if front else -1])
             for west, east, south, north, height, front, _ in given]
    scene = scene_of(*((part @ turn.T, BLACK, {"two_sided": one[6]}) for part, one in zip(parts, given, strict=True)))
    expected = [(number, other) for (number, a), (other, b) in combinations(enumerate(given), 2)
                if a[4] == b[4] and (a[5] == b[5] or a[6] or b[6])
                and min(a[1], b[1]) > max(a[0], b[0]) and min(a[3], b[3]) > max(a[2], b[2])]
    assert [tuple(pair) for pair in overlaps(scene).tolist()] == expected
    which = np.array(chosen[:len(given)])
    assert [tuple(pair) for pair in overlaps(scene, which).tolist()] == [
        (one, other) for one, other in expected if which[one] != which[other]]


@pytest.mark.parametrize(("patches", "expected"), [
    ((square(9, 9, 0), SQUARE, RIGHT), [[1, 2]]), ((RIGHT, LEFT), []), ((SQUARE, square(0, 0, 1e-3)), []),
    ((SQUARE, rectangle((0, 0, 0), (1, 0, 0), (0, 0, 1))), [])])
def test_triangles_near_planes_and_walls(patches, expected):
    assert overlaps(scene_of((list(patches), BLACK))).tolist() == expected


@pytest.mark.parametrize("name", ["cornell", "lobby", "city:2", "teapot"])
def test_built_in_scenes_have_none(name):
    assert not len(overlaps(builtin_scene(name)))


def test_the_first_pair_is_named():
    with pytest.warns(InputWarning, match="patches 0 and 1 overlap in one plane, and 2 more pairs: each"):
        warn_of_overlaps(scene_of(([SQUARE] * 3, BLACK)))
