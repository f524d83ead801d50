"""What holds for the teapot and all scenes of the SPD family, and that each scene is the same every time."""

import numpy as np
import pytest

from golden.scene.builtin import BUILTIN, builtin_scene
from tb.golden.scene.closed import assert_good_patches

SCENES = ("teapot", "tetra", "mountain", "rings", "balls", "gears", "tree")
SIZES = [f"{name}:{BUILTIN[name].sizes.start}" for name in SCENES] + list(SCENES)


@pytest.mark.parametrize("spec", SIZES)
def test_patches_are_planar_and_strictly_convex(spec):
    scene = builtin_scene(spec)
    assert_good_patches(scene.vertices, scene.size)


@pytest.mark.parametrize("name", BUILTIN)
def test_scene_is_the_same_every_time(name):
    one, other = builtin_scene(name), builtin_scene(name)
    for field in ("vertices", "material", "surface", "smooth", "two_sided"):
        assert getattr(one, field).tobytes() == getattr(other, field).tobytes()
    assert one.materials == other.materials
    assert one.lights == other.lights
    assert one.camera == other.camera


@pytest.mark.parametrize("name", SCENES)
def test_scene_has_a_light_out_of_view_and_its_camera_sees_it_whole(name):
    scene = builtin_scene(name)
    emits = scene.channels("emission").max(axis=1) > 0
    right, up, forward = scene.camera.axes
    relative = scene.vertices - scene.camera.eye
    tangent = np.tan(np.radians(scene.camera.fov) / 2)
    depth = relative @ forward
    with np.errstate(divide="ignore", invalid="ignore"):
        inside = (depth > 0) & (np.abs(relative @ right / depth) < tangent) & (np.abs(relative @ up / depth) < tangent)
    assert emits.any() or scene.lights
    assert not inside[emits].any()
    # Grounds extend past the picture's edge; objects on them do not.
    grounds = ("floor", "wall", "ground", "field", "water", "dark square", "light square", "lamp")
    object_ = ~np.isin([scene.materials[number].name for number in scene.material], grounds)
    assert inside[object_].all()


@pytest.mark.parametrize("spec", ["mountain:8", "gears:5", "balls:3", "tree:8", "rings:3", "tetra:8", "teapot:20"])
def test_larger_sizes_are_built(spec):
    name, size = spec.split(":")
    assert len(builtin_scene(spec)) > len(builtin_scene(f"{name}:{int(size) - 1}"))
