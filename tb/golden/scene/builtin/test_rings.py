import numpy as np
import pytest

from golden.scene.builtin.rings import RADIUS, pentagons, pyramid, rings


@pytest.mark.parametrize(("layers", "count"), [(1, 30), (2, 150), (3, 420), (7, 4200)])
def test_pyramid_has_the_published_number_of_spheres_and_of_cylinders(layers, count):
    """4200 of each and the wall are the 8401 primitives of SPD's default size."""
    assert len(pyramid(layers)) * pentagons()[..., 0].size == count


def test_scene_has_a_smooth_group_for_each_sphere_and_cylinder():
    scene = rings(1)
    assert len(np.unique(scene.smooth)) == 30 + 30 + 2


def test_pentagons_are_regular_about_one_middle_and_their_corners_those_of_an_icosidodecahedron():
    corners = pentagons()
    assert np.linalg.norm(corners, axis=2) == pytest.approx(1)
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    assert sides == pytest.approx(2 * np.sin(np.pi / 5))
    points = corners.reshape(-1, 3)
    near = np.sort(np.linalg.norm(points[:, None] - points, axis=2), axis=1)[:, 1:5]
    assert near == pytest.approx(2 * np.sin(np.pi / 10))


def test_tubes_nearly_touch_and_do_not():
    corners = pentagons()
    steps = np.linspace(0, 1, 101)[:, None, None, None]
    along = corners + steps * (np.roll(corners, -1, axis=1) - corners)
    pentagon = along.transpose(1, 0, 2, 3).reshape(6, -1, 3)
    nearest = min(np.linalg.norm(pentagon[i][:, None] - pentagon[j], axis=2).min() for i in range(6) for j in range(i))
    assert 2 * RADIUS < nearest < 2.05 * RADIUS


def test_sets_do_not_touch():
    middles = pyramid(4)
    apart = np.linalg.norm(middles[:, None] - middles, axis=2) + 9 * np.eye(len(middles))
    assert apart.min() == pytest.approx(2)
