import numpy as np
import pytest

from golden.errors import InputError
from golden.frustum import Hemisphere, Screen, frame
from golden.scene.camera import Camera

POWERS = tuple(2**k for k in range(2, 13))


@pytest.fixture
def normals():
    vectors = np.random.default_rng(20).normal(size=(2000, 3))
    vectors = np.concatenate([vectors, np.eye(3), -np.eye(3), [(1, 2, 3), (-1, -2, -3)]])
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


@pytest.mark.parametrize("azimuths", POWERS)
@pytest.mark.parametrize("polars", POWERS)
def test_weights_sum_to_one_exactly_and_are_within_one_unit_of_the_cell(azimuths, polars):
    hemisphere = Hemisphere(azimuths, polars)
    weights = hemisphere.polar_weights
    assert weights.dtype == np.int64
    assert int(weights.sum()) * azimuths == 2**hemisphere.weight_bits
    low, high = (np.arange(polars) + border for border in (0, 1))
    # sin^2 b - sin^2 a = sin(b + a) sin(b - a) does not cancel as the cumulative sums do.
    cell = np.sin((high + low) * np.pi / 2 / polars) * np.sin(np.pi / 2 / polars) / azimuths
    assert np.abs(weights - cell * 2.0**hemisphere.weight_bits).max() <= 1
    assert weights.min() > 0


def test_weights_have_40_bits_from_2048_azimuths_on():
    assert [Hemisphere(azimuths, 4).weight_bits for azimuths in (4, 1024, 2048, 4096)] == [32, 32, 40, 40]


def test_directions_are_at_the_cell_centres_in_the_stated_order():
    hemisphere = Hemisphere(8, 4)
    table = hemisphere.directions.reshape(4, 8, 3)
    polar = np.degrees(np.arccos(table[..., 2]))
    azimuth = np.degrees(np.arctan2(table[..., 1], table[..., 0])) % 360
    np.testing.assert_allclose(polar, np.array([11.25, 33.75, 56.25, 78.75])[:, None] + np.zeros(8), atol=1e-12)
    np.testing.assert_allclose(azimuth, np.zeros((4, 1)) + np.arange(22.5, 360, 45), atol=1e-12)
    assert (hemisphere.weights.reshape(4, 8) == hemisphere.polar_weights[:, None]).all()


@pytest.mark.parametrize("rays", [(3, 4), (4, 0), (2, 4), (4, 8192), (1000, 256), (-4, 4), (4.0, 4), ("8", 4)])
def test_hemisphere_refuses_grids_the_machine_does_not_have(rays):
    with pytest.raises(InputError, match="must be a power of two from 4 to 4096, not "):
        Hemisphere(*rays)


def test_frames_are_right_handed_and_end_in_the_normal(normals):
    axes = frame(normals)
    np.testing.assert_array_equal(axes[:, 2], normals)
    np.testing.assert_allclose(axes @ axes.transpose(0, 2, 1), np.broadcast_to(np.eye(3), axes.shape), atol=1e-13)
    np.testing.assert_allclose(np.linalg.det(axes), 1, atol=1e-13)


def test_frame_of_one_normal_is_that_of_many(normals):
    np.testing.assert_allclose(frame(normals[7]), frame(normals)[7], rtol=0, atol=1e-15)


def test_near_normals_have_near_frames_unless_opposite_the_pole(normals):
    moved = normals + np.random.default_rng(21).normal(scale=1e-7, size=normals.shape)
    moved /= np.linalg.norm(moved, axis=1, keepdims=True)
    pole = np.array([1, 2, 3]) / np.sqrt(14)
    steady = np.abs(normals @ pole + 0.9) > 1e-6
    assert np.abs(frame(moved) - frame(normals))[steady].max() < 1e-5


@pytest.fixture
def screen():
    return Screen(camera=Camera(eye=(1, 2, 3), target=(1, 5, 3), fov=90), width=6, height=4)


def test_screen_rays_pass_the_pixel_centres(screen):
    rays = screen.rays()
    assert len(rays) == len(screen) == 24
    # Right is +x, up is +z, forward +y; at depth 1 the image is 2 high and, with square pixels, 3 wide.
    np.testing.assert_allclose(rays.direction[0], (-1.25, 1, 0.75), atol=1e-15)
    np.testing.assert_allclose(rays.direction[5], (1.25, 1, 0.75), atol=1e-15)
    np.testing.assert_allclose(rays.direction[-1], (1.25, 1, -0.75), atol=1e-15)
    assert (rays.origin == (1, 2, 3)).all()


def test_screen_offsets_move_right_and_down_by_pixels(screen):
    pixels = np.array([0, 7, 7])
    offsets = np.array([(0.5, 0.5), (0, 0), (-0.25, 0.5)])
    directions = screen.rays(pixels, offsets).direction
    np.testing.assert_allclose(directions, [(-1, 1, 0.5), (-0.75, 1, 0.25), (-0.875, 1, 0)], atol=1e-15)


@pytest.mark.parametrize("size", [(0, 4), (4, -1), (65537, 4), (4, 4.5)])
def test_screen_refuses_absurd_sizes(size):
    with pytest.raises(InputError, match="must be 1 to 65536 pixels, not "):
        Screen(camera=Camera(eye=(0, 0, 0), target=(0, 1, 0)), width=size[0], height=size[1])
