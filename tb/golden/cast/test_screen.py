import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.screen import Screen
from golden.scene.camera import Camera


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


@pytest.mark.parametrize("size", [(0, 4), (4, -1), (65537, 4)])
def test_screen_refuses_absurd_sizes(size):
    with pytest.raises(InputError, match="must be 1 to 65536 pixels, not "):
        Screen(camera=Camera(eye=(0, 0, 0), target=(0, 1, 0)), width=size[0], height=size[1])


@pytest.mark.parametrize("size", [(4, 4.5), ("4", 4), (4, True)])
def test_a_screen_of_no_whole_pixels_is_a_programming_error(size):
    with pytest.raises(TypeError, match=r"screen: (Width|Height) must be an int, not "):
        Screen(camera=Camera(eye=(0, 0, 0), target=(0, 1, 0)), width=size[0], height=size[1])
