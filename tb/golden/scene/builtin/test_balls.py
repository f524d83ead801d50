import numpy as np
import pytest

from golden.scene.builtin.balls import balls, flake
from tb.golden.scene.closed import assert_closed


@pytest.mark.parametrize(("levels", "count"), [(0, 1), (1, 10), (2, 91), (3, 820), (4, 7381)])
def test_flake_has_the_published_number_of_spheres(levels, count):
    """7381 and the floor are the 7382 primitives of SPD's default size."""
    assert sum(map(len, flake(levels))) == count


def test_children_touch_their_parent_and_no_sibling():
    parent, children, grandchildren = flake(2)
    distance = np.linalg.norm(children[:, :3] - parent[0, :3], axis=1)
    assert distance == pytest.approx(parent[0, 3] + children[:, 3])
    apart = np.linalg.norm(children[:, None, :3] - children[:, :3], axis=2) + np.eye(9)
    assert apart.min() > 2 * children[0, 3] - 1e-9
    offset = grandchildren.reshape(9, 9, 4)[:, :, :3] - children[:, None, :3]
    assert np.linalg.norm(offset, axis=2) == pytest.approx(4 / 3 * children[0, 3])


def test_children_lie_on_the_outer_side_of_their_parent():
    _, children, grandchildren = flake(2)
    direction = children[:, None, :3] / np.linalg.norm(children[:, None, :3], axis=2, keepdims=True)
    offset = grandchildren.reshape(9, 9, 4)[:, :, :3] - children[:, None, :3]
    along = (offset * direction).sum(axis=2) / np.linalg.norm(offset, axis=2)
    assert np.sort(along, axis=1) == pytest.approx(np.tile([0] * 6 + [np.sqrt(2 / 3)] * 3, (9, 1)), abs=1e-12)


def test_each_ball_is_one_closed_smooth_surface():
    scene = balls(1)
    groups = [scene.vertices[scene.smooth == group] for group in np.unique(scene.smooth)]
    assert len(groups) == 12
    for group in groups[:10]:
        assert_closed(group)
