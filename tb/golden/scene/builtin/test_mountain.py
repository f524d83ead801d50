import numpy as np
import pytest

from golden.scene.builtin.mountain import BALL, crystal, mountain, terrain
from tb.golden.scene.closed import assert_closed


@pytest.mark.parametrize(("levels", "count"), [(1, 8), (2, 32), (3, 128), (6, 8192)])
def test_terrain_has_the_published_number_of_triangles(levels, count):
    """8192 and the four balls are the 8196 primitives of SPD's default size."""
    assert len(terrain(levels)) == count


def test_terrain_covers_its_square_once_facing_up_with_its_border_at_sea_level():
    triangles = terrain(5)
    vectors = 0.5 * np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    assert vectors[:, 2] == pytest.approx(4 / len(triangles))
    border = np.abs(triangles[..., :2]).max(axis=2) == 1
    assert not triangles[border][:, 2].any()
    assert len(np.unique(triangles.reshape(-1, 3), axis=0)) == 33**2


def test_levels_refine_the_same_mountain():
    coarse = np.unique(terrain(3).reshape(-1, 3), axis=0)
    fine = {tuple(point) for point in terrain(4).reshape(-1, 3).tolist()}
    assert all(tuple(point) in fine for point in coarse.tolist())


def test_crystal_balls_just_miss_each_other():
    balls = crystal((0, 0, 0))
    assert balls.shape == (4, 4)
    apart = np.linalg.norm(balls[:, None, :3] - balls[:, :3], axis=2)[~np.eye(4, dtype=bool)]
    assert apart == pytest.approx(2 * BALL)
    assert (balls[:, 3] < BALL).all()


def test_balls_are_closed_glass():
    scene = mountain(2)
    glass = scene.channels("transparent").max(axis=1) > 0
    groups = np.unique(scene.smooth[glass])
    assert len(groups) == 4
    for group in groups:
        assert_closed(scene.vertices[scene.smooth == group])
