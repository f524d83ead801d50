"""A patch costs what the steps take that it passes: its side, the horizon, the faces, its squares."""

import numpy as np
import pytest

from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.gather.node_memory import SIDE, SQUARES
from radiosity.machines.gather.projection_work import ProjectionWork
from tb.golden.light.scenes import BLACK, rectangle, scene_of
from tb.radiosity.machines.gather.nodes import room

pytestmark = pytest.mark.usefixtures("interpreted")

TIMING = NodeTiming(operation=1)
FLOOR = rectangle((-0.01, -0.01, 0), (0.02, 0, 0), (0, 0.02, 0))


def operations(patch, **options):
    """Of the projection of a patch on the hemicube of the floor."""
    work = ProjectionWork(scene_of((FLOOR, BLACK), (patch, BLACK, options)), TIMING)
    return int(work.of_blocks(np.array([0, 1]), 2)[0, 1])


def facing_down(x, y, z, size):
    return rectangle((x - size / 2, y - size / 2, z), (0, size, 0), (size, 0, 0))


def test_a_patch_that_does_not_face_the_centre_leaves_first():
    away = facing_down(0, 0, 1, 0.1)[::-1]
    assert operations(away) == TIMING.visibility
    assert operations(away, two_sided=True) == operations(facing_down(0, 0, 1, 0.1))


def test_a_patch_below_the_horizon_leaves_second():
    below = rectangle((-0.05, -0.05, -1), (0.1, 0, 0), (0, 0.1, 0))
    assert operations(below) == TIMING.visibility + TIMING.horizon


@pytest.mark.parametrize(("at", "depth"), [((0, 0, 1), 1), ((0.5, 0, 1), 1), ((2, 0, 1), 2), ((0.3, -3, 1), 3)])
def test_squares_are_the_solid_angle_over_that_of_a_square(at, depth):
    """A small patch of area a, seen under an angle: on the face at ``depth`` it is a cell of squares of 1/50."""
    size, far = 0.05, np.linalg.norm(at)
    angle = size * size / far**2 * (at[2] / far)
    expected = angle * SIDE**2 / (depth / far) ** 3
    before = TIMING.visibility + TIMING.horizon + TIMING.clipping + TIMING.projection
    assert abs((operations(facing_down(*at, size)) - before) / TIMING.square - expected) <= 1


def test_a_patch_is_projected_on_each_face_that_has_a_corner_of_it():
    one, five = (operations(facing_down(0, 0, 1, size)) for size in (0.1, 20.0))
    assert five - one >= 3 * TIMING.projection
    assert five < TIMING.visibility + TIMING.horizon + TIMING.clipping + 5 * TIMING.projection + TIMING.square * SQUARES


def test_a_patch_covers_no_more_squares_than_a_hemicube_has():
    """The nearest of patches is counted by its solid angle over that of a square at a corner, which is the smallest."""
    to = np.full(3, 0.001)
    one, two = np.array([1.0, -1, 0]), np.array([1.0, 1, -2])
    near = to + np.array([-one - two, -one + two, one + two, one - two])
    most = TIMING.visibility + TIMING.horizon + TIMING.clipping + 5 * TIMING.projection + TIMING.square * SQUARES
    assert most - 5 * TIMING.projection < operations(near, two_sided=True) <= most


def test_blocks_add_up_to_rows():
    _, _, work = room(60)
    block = np.random.default_rng(0).integers(0, 7, 60)
    assert np.array_equal(work.of_blocks(block, 7).sum(axis=1) + work.clearing + work.summing, work.of_rows)
    assert work.clearing == SQUARES * NodeTiming().clearing * NodeTiming().operation
    assert work.summing == SQUARES * NodeTiming().summing * NodeTiming().operation


@pytest.mark.parametrize(("wrong", "error", "message"), [
    ({"setup": -1}, ValueError, "Setup must be at least 0, not -1"),
    ({"operation": 0}, ValueError, "Operation must be at least 1, not 0"),
    ({"word": 1.43}, TypeError, "Word must be an int, not 1.43")])
def test_numbers_out_of_range_are_refused(wrong, error, message):
    with pytest.raises(error, match=message):
        NodeTiming(**wrong)
