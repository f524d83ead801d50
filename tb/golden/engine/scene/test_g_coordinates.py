import numpy as np
import pytest

from golden.base.errors import InputError
from golden.engine.config import Numbers
from golden.engine.scene.g_coordinates import GCoordinates
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.builtin import builtin_scene


@pytest.fixture
def scene():
    return builtin_scene("cornell")


@pytest.mark.parametrize("name", ["cornell", "lobby", "man"])
def test_scene_camera_and_origins_fit_with_the_margin(name):
    scene = builtin_scene(name)
    origin = scene.bounds[1] + (0, 0, 2 * scene.size)
    coordinates = GCoordinates.of(scene, Numbers(), origin)
    held = coordinates.integers(np.concatenate([scene.vertices.reshape(-1, 3), [origin, scene.camera.eye]]))
    assert held.min() == 2**14
    assert held.max() == 2**24 - 2**14


def test_one_scale_for_all_axes_and_nearest_integers(scene):
    coordinates = GCoordinates.of(scene, Numbers())
    points = np.random.default_rng(1).uniform(*scene.bounds, (500, 3))
    back = coordinates.points(coordinates.integers(points))
    assert np.abs(back - points).max() * coordinates.scale <= 2.0**-25 * (1 + 1e-9)


def test_shared_vertices_stay_shared(scene):
    geometry = PatchGeometry.of(scene, Numbers())
    _, exact = np.unique(scene.vertices.reshape(-1, 3), axis=0, return_inverse=True)
    _, integer = np.unique(geometry.vertices.reshape(-1, 3), axis=0, return_inverse=True)
    assert (exact == integer).all()


def test_a_cell_is_rounded_up(scene):
    coordinates = GCoordinates.of(scene, Numbers(), scene.bounds[1] + 5 * scene.size)
    longest = np.ptp(coordinates.integers(scene.bounds), axis=0).max()
    for fraction in (1, 0.5, 0.0625, 0.01):
        size = coordinates.cell_size(fraction)
        assert size >= fraction * (longest - 1)
        assert size - fraction * longest < 2


def test_points_outside_the_cube_are_refused(scene):
    coordinates = GCoordinates.of(scene, Numbers())
    with pytest.raises(InputError, match=r"^Point must be within the scene's coordinates, not "):
        coordinates.integers(scene.bounds[1] + 10 * scene.size)
    with pytest.raises(InputError, match="Origins must be finite"):
        GCoordinates.of(scene, Numbers(), (0, np.nan, 0))
