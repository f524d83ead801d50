from dataclasses import replace

import numpy as np
import pytest

from golden.cast.default_camera import default_camera
from golden.cast.grid import Grid
from golden.cast.rays import Rays
from golden.scene.builtin import builtin_scene
from golden.scene.camera import Camera
from golden.scene.scene import Scene
from golden.scene.tessellate import sphere


def nameless(name):
    return replace(builtin_scene(name), camera=None)


def view(scene, camera, *, size=48):
    """Hits of the rays of a square image."""
    steps = (np.arange(size) + 0.5) / size * 2 - 1
    x, y = (side.ravel()[:, None] * np.tan(np.radians(camera.fov / 2)) for side in np.meshgrid(steps, -steps))
    right, up, forward = camera.axes
    directions = forward + x * right + y * up
    return Grid(scene).nearest(Rays(np.tile(camera.eye, (len(directions), 1)), directions))


def inside_box(scene, point):
    low, high = scene.bounds
    return bool(np.all((point > low) & (point < high)))


def test_a_scene_keeps_its_own_camera():
    camera = Camera(eye=(1, 2, 3), target=(0, 0, 0))
    assert default_camera(replace(builtin_scene("furnace:1"), camera=camera)) is camera


@pytest.mark.parametrize(("name", "up"), [
    ("furnace:3", (0, 0, 1)), ("furnace:3", (0, 0, -1)), ("furnace:3", (0, -1, 0)), ("lobby", (0, 0, 1))])
def test_a_closed_room_is_seen_from_within_and_above(name, up):
    scene = replace(nameless(name), up=up)
    camera = default_camera(scene)
    assert inside_box(scene, camera.eye)
    hits = view(scene, camera)
    assert (hits.patch >= 0).all()
    assert np.median(hits.t) > 0.2 * scene.size
    assert camera.axes[2] @ np.array(scene.up) < 0


def test_a_room_without_a_front_is_seen_through_it_as_a_whole():
    scene = nameless("cornell")
    camera = default_camera(scene)
    assert not inside_box(scene, camera.eye)
    assert len(np.unique(view(scene, camera).patch)) > 10
    hits = view(scene, camera)
    assert 0.85 < (hits.patch >= 0).mean() < 1


@pytest.mark.parametrize("up", [(0, 0, 1), (0, 1, 0), (1, 0, 0), (0, 0, -1), (0.6, 0, 0.8)])
def test_an_object_is_framed_from_outside_and_above(up):
    patches = sphere((5, -3, 2), 2.0)
    scene = Scene(name="ball", vertices=patches, material=np.zeros(len(patches)), up=up,
                  materials=builtin_scene("furnace:1").materials[:1])
    camera = default_camera(scene)
    assert np.subtract(camera.eye, camera.target) @ np.array(up) > 0
    hits = view(scene, camera)
    seen = (hits.patch >= 0).reshape(48, 48)
    assert 0.25 < seen.mean() < 0.9
    assert not seen[[0, -1]].any()
    assert not seen[:, [0, -1]].any()


def test_a_box_with_its_faces_outwards_and_no_light_is_an_object():
    scene = nameless("furnace:2")
    dark = replace(scene.materials[0], emission=(0, 0, 0))
    outwards = replace(scene, vertices=scene.vertices[:, [3, 2, 1, 0]], materials=(dark,) * len(scene.materials))
    assert not inside_box(outwards, default_camera(outwards).eye)
    inwards = replace(scene, materials=(dark,) * len(scene.materials))
    assert inside_box(inwards, default_camera(inwards).eye)


def test_a_lamp_far_above_does_not_make_the_object_small():
    patches = sphere((0, 0, 0), 1.0)
    lamp = np.array([[(-1, -1, 50), (-1, 1, 50), (1, 1, 50), (1, -1, 50)]], dtype=float)
    source = builtin_scene("furnace:1").materials[0]
    scene = Scene(name="ball", vertices=np.concatenate((patches, lamp)),
                  material=np.r_[np.zeros(len(patches)), 1],
                  materials=(replace(source, emission=(0, 0, 0)), replace(source, emission=(1, 1, 1))))
    assert np.linalg.norm(np.subtract(default_camera(scene).eye, (0, 0, 0))) < 6
