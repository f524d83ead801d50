"""The Cornell box keeps to its published measurements."""

import numpy as np
import pytest

from golden.scene.builtin.cornell import cornell
from tb.golden.scene.builtin.solids import area_vectors


@pytest.fixture(scope="module")
def scene():
    return cornell()


def _of(scene, name):
    return scene.vertices[[scene.materials[number].name == name for number in scene.material]]


def test_camera_has_the_published_film(scene):
    assert scene.camera.eye == (278, 273, -800)
    np.testing.assert_allclose(scene.camera.axes, [[-1, 0, 0], [0, 1, 0], [0, 0, 1]], atol=0)
    assert np.tan(np.radians(scene.camera.fov / 2)) == pytest.approx(0.0125 / 0.035)


def test_lamp_has_the_published_size_place_and_light(scene):
    (lamp,) = _of(scene, "light")
    np.testing.assert_array_equal([lamp.min(axis=0), lamp.max(axis=0)], [(213, 548.8, 227), (343, 548.8, 332)])
    (emission,) = {material.emission for material in scene.materials if material.emits}
    assert emission == (18.387, 10.987, 2.754)
    np.testing.assert_array_equal(area_vectors(lamp[None]), [(0, -130 * 105, 0)])


def test_ceiling_with_its_lamp_covers_the_published_rectangle_once(scene):
    level = scene.vertices[:, :, 1].min(axis=1) == 548.8
    assert area_vectors(scene.vertices[level]).sum(axis=0)[1] == pytest.approx(-556 * 559.2)
    assert np.count_nonzero(level) == 5


def test_box_is_open_only_at_the_front(scene):
    """Four edges of the room have no partner: the frame of the front."""
    room = scene.vertices[:10]
    corner = np.unique(room.reshape(-1, 3), axis=0, return_inverse=True)[1].reshape(-1, 4)
    edges = {(a, b) for row in corner for a, b in zip(row, np.roll(row, -1), strict=True) if a != b}
    points = dict(zip(corner.ravel(), room.reshape(-1, 3), strict=True))
    lonely = [(a, b) for a, b in edges if (b, a) not in edges]
    assert len(lonely) == 4
    assert all(points[a][2] == points[b][2] == 0 for a, b in lonely)


def test_walls_have_the_published_colours_on_their_sides(scene):
    assert _of(scene, "red")[:, :, 0].min() == 549.6
    assert _of(scene, "green")[:, :, 0].max() == 0
    diffuse = {material.name: material.diffuse for material in scene.materials}
    assert diffuse["white"] == (0.885809, 0.698859, 0.666422)
    assert diffuse["green"] == (0.105421, 0.377980, 0.076425)
    assert diffuse["red"] == (0.570068, 0.043014, 0.044371)


def test_all_fronts_of_the_walls_look_into_the_room(scene):
    centre = scene.vertices[:10].mean(axis=1)
    assert (np.einsum("ni,ni->n", (278, 274, 280) - centre, scene.normals[:10]) > 0).all()


@pytest.mark.parametrize(("first", "height", "side"), [(10, 165, (160, 167)), (15, 330, (165, 167))])
def test_blocks_stand_upright_with_fronts_outside(scene, first, height, side):
    block = scene.vertices[first:first + 5]
    assert block[:, :, 1].min() == 0
    assert block[:, :, 1].max() == height
    inside = block.reshape(-1, 3).mean(axis=0)
    assert (np.einsum("ni,ni->n", block.mean(axis=1) - inside, scene.normals[first:first + 5]) > 0).all()
    widths = np.linalg.norm(block[4] - np.roll(block[4], 1, axis=0), axis=1)
    assert side[0] < widths.min() <= widths.max() < side[1] + 3
