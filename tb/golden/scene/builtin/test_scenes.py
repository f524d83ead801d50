"""What all built-in scenes with a room around them have in common."""

import numpy as np
import pytest

from golden.cast.grid import Grid
from golden.cast.rays import Rays
from golden.scene.builtin import builtin_scene
from golden.scene.polygons import is_convex_quad
from tb.golden.scene.builtin.solids import components, is_closed, overlaps, volume
from tb.golden.scene.closed import assert_good_patches

# Those with a closed room of more than the cube's faces.
HALLS = ("lobby", "room1627", "cubes", "man", "phone")


@pytest.fixture(scope="module", params=("cornell", "furnace", *HALLS))
def scene(request):
    return builtin_scene(request.param)


@pytest.fixture(scope="module", params=HALLS)
def hall(request):
    return builtin_scene(request.param)


def test_patches_are_planar_and_strictly_convex(scene):
    assert_good_patches(scene.vertices, scene.size)
    assert is_convex_quad(scene.vertices[~scene.is_triangle]).all()


def test_no_patch_covers_another(scene):
    assert overlaps(scene.vertices, scene.size) == []


def test_a_surface_is_planar_and_of_one_material(scene):
    for surface in np.unique(scene.surface):
        members = np.flatnonzero(scene.surface == surface)
        first = members[0]
        assert (scene.material[members] == scene.material[first]).all()
        heights = (scene.vertices[members] - scene.vertices[first, 0]) @ scene.normals[first]
        assert np.abs(heights).max() < 1e-9 * scene.size
        assert (scene.normals[members] @ scene.normals[first] > 0).all()


def test_materials_are_plausible(scene):
    for material in scene.materials:
        shares = np.add(np.add(material.diffuse, material.specular), material.transparent)
        assert shares.max() <= 0.9
        assert material.emits or shares.max() > 0
    assert any(material.emits for material in scene.materials)


def test_lights_are_few_and_all_materials_used(hall):
    emitting = hall.channels("emission").max(axis=1) > 0
    assert 1 <= np.count_nonzero(emitting) <= 12
    assert set(hall.material.tolist()) == set(range(len(hall.materials)))


def test_room_is_one_closed_shell_around_everything(hall):
    """Neighbours in the shell share whole edges, so no ray gets out between them."""
    parts = components(hall.vertices)
    shells = [part for part in parts if is_closed(part) and volume(part) < 0]
    assert len(shells) == 1
    (shell,) = shells
    np.testing.assert_array_equal([shell.min(axis=(0, 1)), shell.max(axis=(0, 1))], hall.bounds)


def test_nothing_leaves_the_room_and_only_fronts_are_seen(hall):
    """From the camera and from 16 sample points on the ceiling."""
    random = np.random.default_rng(227)
    lower, upper = hall.bounds
    lower, upper = np.maximum(lower, [-np.inf, -np.inf, 0]), upper - [0, 0, 1e-3 * hall.size]
    share = (np.stack(np.meshgrid(np.arange(4), np.arange(4)), axis=-1).reshape(-1, 2) + 0.5) / 4
    points = np.column_stack([lower[:2] + share * (upper - lower)[:2], np.full(16, upper[2])])
    origin = np.concatenate([np.repeat(points, 400, axis=0), np.tile(hall.camera.eye, (3600, 1))])
    direction = random.normal(size=origin.shape)
    direction[:6400, 2] = -np.abs(direction[:6400, 2])
    hits = Grid(hall).nearest(Rays(origin, direction))
    assert (hits.patch >= 0).all()
    facing = np.einsum("ni,ni->n", hall.normals[hits.patch], direction) < 0
    assert (facing | hall.two_sided[hits.patch]).all()


def test_no_part_of_a_patch_is_outside_the_room(hall):
    """Light that leaves a front stays in the room."""
    random = np.random.default_rng(1297)
    patch = np.tile(np.arange(len(hall)), 8)
    u, v = random.random((2, len(patch), 1))
    corners = hall.vertices[patch]
    origin = (1 - v) * ((1 - u) * corners[:, 0] + u * corners[:, 1]) + v * ((1 - u) * corners[:, 3] + u * corners[:, 2])
    direction = random.normal(size=origin.shape)
    direction *= np.sign(np.einsum("ni,ni->n", direction, hall.normals[patch]))[:, None]
    hits = Grid(hall).nearest(Rays(origin, direction, hall.surface[patch]))
    assert (hits.patch >= 0).all()


def test_ceiling_is_the_top_and_faces_down(hall):
    """The thesis takes its sample points there."""
    top = hall.vertices[:, :, 2].min(axis=1) >= hall.bounds[1, 2]
    assert (hall.normals[top, 2] == -1).all()
    area = np.prod((hall.bounds[1] - hall.bounds[0])[:2])
    assert hall.areas[top].sum() > 0.9 * area


def test_closed_objects_have_their_fronts_outside(hall):
    parts = components(hall.vertices)
    closed = [part for part in parts if is_closed(part)]
    assert len(closed) >= 3
    assert sum(volume(part) <= 0 for part in closed) == 1


def test_camera_is_inside_and_sees_more_than_a_wall(hall):
    eye = np.array(hall.camera.eye)
    assert (eye > hall.bounds[0]).all()
    assert (eye < hall.bounds[1]).all()
    right, up, forward = hall.camera.axes
    reach = np.tan(np.radians(hall.camera.fov / 2)) * np.linspace(-1, 1, 48)
    x, y = np.meshgrid(reach, reach)
    direction = forward + x.reshape(-1, 1) * right + y.reshape(-1, 1) * up
    hits = Grid(hall).nearest(Rays(np.tile(eye, (len(direction), 1)), direction))
    assert len(np.unique(hall.material[hits.patch])) >= 5
