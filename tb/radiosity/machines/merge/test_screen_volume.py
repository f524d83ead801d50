"""Volumes fill the screen, and boxes have the pixels of their faces."""

from itertools import product

import numpy as np
import pytest

from golden.base.errors import InputError
from radiosity.machines.merge.screen_volume import drawn_direction, view_volume
from radiosity.machines.merge.tetrahedra import cut_grid
from tb.radiosity.machines.merge.marched import small_volume

pytestmark = pytest.mark.usefixtures("interpreted")


def test_a_view_keeps_shapes_and_fills_the_screen():
    volume, screen = small_volume(3)
    at, seen = volume.points, screen.points
    rng = np.random.default_rng(0)
    one, other = rng.integers(0, len(at), (2, 50))
    before = np.linalg.norm(at[one] - at[other], axis=1)
    ratio = np.linalg.norm(seen[one] - seen[other], axis=1)[before > 0] / before[before > 0]
    assert np.allclose(ratio, ratio[0])
    extent = np.ptp(seen[:, :2], axis=0)
    assert extent.max() == pytest.approx(30)
    assert (seen[:, :2].min(axis=0) >= 0).all()


def test_x_is_right_y_is_down_and_z_is_away():
    axes = np.meshgrid(*(np.arange(2.0),) * 3, indexing="ij")
    cube = cut_grid(np.stack(axes, axis=-1), np.zeros((2, 2, 2)))
    seen = view_volume(cube, np.array([0, 1, -0.5]), 40, 40).points.reshape(2, 2, 2, 3)
    assert (seen[1, :, :, 0] > seen[0, :, :, 0]).all()
    assert (seen[:, :, 1, 1] < seen[:, :, 0, 1]).all()
    assert (seen[:, 1, :, 2] > seen[:, 0, :, 2]).all()


def test_boxes_are_the_pixels_that_faces_touch():
    _, screen = small_volume(3)
    at = screen.points[screen.faces][:, :, :2]
    assert np.array_equal(screen.boxes[:, :2], np.floor(at.min(axis=1)))
    assert np.array_equal(screen.boxes[:, 2:], np.floor(at.max(axis=1)))


@pytest.mark.parametrize("size", [*product((1, 2, 3, 40), repeat=2)])
def test_a_screen_has_a_pixel_between_its_edges(size):
    volume, _ = small_volume(3)
    if min(size) < 3:
        with pytest.raises(InputError, match=f"must be at least 3 for a volume, not {next(n for n in size if n < 3)}"):
            view_volume(volume, drawn_direction(3), *size)
        return
    screen = view_volume(volume, drawn_direction(3), *size)
    assert (np.ptp(screen.points[:, :2], axis=0) - (np.array(size) - 2)).max() == pytest.approx(0)
    assert np.array_equal(screen.boxes[:, :2], np.floor(screen.points[screen.faces][:, :, :2].min(axis=1)))


def test_directions_look_down():
    for seed in range(20):
        direction = drawn_direction(seed)
        assert np.linalg.norm(direction) == pytest.approx(1)
        assert -0.9 < direction[2] < -0.1
