import numpy as np
import pytest

from golden.scene.builtin.gears import TEETH, gears, outline, train
from tb.golden.scene.closed import assert_closed


@pytest.mark.parametrize(("count", "primitives"), [(1, 146), (2, 1168), (3, 3942), (4, 9344)])
def test_train_has_the_published_number_of_polygons(count, primitives):
    """9344 and the ground are the 9345 primitives of SPD's default size: two faces and 144 sides a gear."""
    assert len(train(count)) * (2 + len(outline(0.0))) == primitives


def test_each_gear_has_two_faces_and_its_sides_as_surfaces():
    scene = gears(1)
    gear = np.array(["gear" in scene.materials[number].name or "glass" in scene.materials[number].name
                     for number in scene.material])
    assert len(np.unique(scene.surface[gear])) == 146
    assert_closed(scene.vertices[gear])


def test_gear_faces_outwards_and_has_its_volume():
    scene = gears(1)
    gear = scene.vertices[:2 * 2 * TEETH + 4 * TEETH]
    vectors = scene.area_vectors[:len(gear)]
    volume = (vectors * gear.mean(axis=1)).sum() / 3
    x, y = outline(0.0).T
    area = 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()
    assert volume == pytest.approx(0.1 * area, rel=1e-12)


def test_neighbouring_gears_mesh_without_touching():
    """No corner of one gear is inside the other's outline, and they do overlap as circles."""
    gear = {index: (center, radius, turn) for index, center, radius, turn in train(2)}
    center, radius, turn = gear[0, 0, 0]
    for index in ((1, 0, 0), (0, 1, 0)):
        other_center, _, other_turn = gear[index]
        assert np.linalg.norm(other_center - center) < 2 * 0.995 * radius
        one = center[:2] + radius * outline(turn)
        other = other_center[:2] + radius * outline(other_turn)
        assert not inside(one, other).any()
        assert not inside(other, one).any()


def inside(points, polygon):
    """Even-odd rule."""
    a, b = polygon, np.roll(polygon, -1, axis=0)
    x, y = points[:, None, 0], points[:, None, 1]
    crosses = (a[:, 1] > y) != (b[:, 1] > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = a[:, 0] + (y - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
    return (crosses & (x < at)).sum(axis=1) % 2 == 1
