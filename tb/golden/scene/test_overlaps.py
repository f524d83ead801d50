import numpy as np
import pytest

from golden.errors import InputWarning
from golden.scene.builtin import builtin_scene
from golden.scene.overlaps import overlaps, warn_of_overlaps
from tb.golden.light.scenes import BLACK, rectangle, scene_of


def square(x, y, z):
    return rectangle((x, y, z), (1, 0, 0), (0, 1, 0))


SQUARE = square(0, 0, 0)
TURNED = rectangle((0, 0, 0), (0, 1, 0), (1, 0, 0))
RIGHT = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (1, 1, 0)], dtype=float)
LEFT = np.array([(0, 0, 0), (1, 1, 0), (0, 1, 0), (0, 1, 0)], dtype=float)


@pytest.mark.parametrize(("patches", "two_sided", "expected"), [
    ((SQUARE, SQUARE), False, [(0, 1)]), ((SQUARE, square(0.5, 0.5, 0)), False, [(0, 1)]),
    ((square(9, 9, 0), SQUARE, RIGHT), False, [(1, 2)]), ((SQUARE, TURNED), True, [(0, 1)]),
    ((SQUARE, TURNED), False, []), ((SQUARE, square(1, 0, 0)), False, []), ((RIGHT, LEFT), False, []),
    ((SQUARE, square(0, 0, 1e-3)), False, []), ((SQUARE, square(0, 3, 0)), False, []),
    ((SQUARE, rectangle((0, 0, 0), (1, 0, 0), (0, 0, 1))), False, [])])
def test_overlaps_in_any_plane(patches, two_sided, expected):
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    for matrix in np.eye(3), turn:
        scene = scene_of(([patch @ matrix.T for patch in patches], BLACK, {"two_sided": two_sided}))
        assert overlaps(scene).tolist() == [list(pair) for pair in expected]


@pytest.mark.parametrize("name", ["cornell", "lobby", "city:2", "teapot"])
def test_built_in_scenes_have_none(name):
    assert not len(overlaps(builtin_scene(name)))


def test_the_first_pair_is_named():
    with pytest.warns(InputWarning, match="patches 0 and 1 overlap in one plane, and 2 more pairs: each"):
        warn_of_overlaps(scene_of(([SQUARE] * 3, BLACK)))
