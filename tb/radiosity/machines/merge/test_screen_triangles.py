"""Patches become triangles on the screen: culled, clipped, shaded, with a depth that is linear there."""

import numpy as np
import pytest

from golden.scene.builder import SceneBuilder
from golden.scene.camera import Camera
from golden.scene.material import Material
from radiosity.machines.merge.screen_triangles import project_scene

CAMERA = Camera(eye=(0, 0, 0), target=(0, 0, -2), up=(0, 1, 0), fov=90)
GREY = Material(name="grey", diffuse=(0.5, 0.5, 0.5))


def scene(*patches):
    builder = SceneBuilder("patches")
    builder.add(np.array(patches, dtype=float), GREY)
    return builder.build()


SQUARE = ((-1, -1, -2), (1, -1, -2), (1, 1, -2), (-1, 1, -2))


def test_corners_are_where_the_pinhole_sees_them():
    triangles, number = project_scene(scene(SQUARE), CAMERA, 9, 9)
    assert number.tolist() == [0, 1]
    # The screen is 9 pixels wide at twice the distance: 4.5 pixels for one unit at distance 1.
    assert triangles.corners[0] == pytest.approx(np.array([(1.75, 6.25, -0.5), (6.25, 6.25, -0.5), (6.25, 1.75, -0.5)]))
    assert triangles.dealt == 2


def test_backs_are_culled_and_keep_their_number():
    triangles, number = project_scene(scene(SQUARE[::-1], SQUARE), CAMERA, 9, 9)
    assert (number.tolist(), triangles.dealt) == ([2, 3], 4)


def test_what_is_behind_the_eye_is_clipped():
    """A floor that runs from before the eye to behind it: its front part is all that is left."""
    floor = ((-1, -1, -4), (-1, -1, 4), (1, -1, 4), (1, -1, -4))
    triangles, number = project_scene(scene(floor), CAMERA, 9, 9)
    assert set(number) == {0, 1}
    assert np.isfinite(triangles.corners).all()
    assert (triangles.corners[:, :, 2] >= -1 / (0.002 * (1 - 1e-9))).all()
    # All that is drawn lies below the horizon.
    assert (triangles.corners[:, :, 1] > 4).all()
    one, _ = project_scene(scene(((-1, -1, 4), (1, -1, 4), (1, 1, 4), (-1, 1, 4))), CAMERA, 9, 9)
    assert len(one.corners) == 0


def test_clipping_keeps_the_area_that_is_seen():
    """Of a triangle with one or two corners behind the eye the part beyond the near plane remains."""
    for far, parts in ((1, 1), (2, 2)):
        depths = (-2.0,) * far + (1.0,) * (3 - far)
        corners = np.stack([(-1, 1, 0.2), (-1, -1, 1), depths], axis=1)
        corners = np.concatenate([corners, corners[2:]])[None]
        front = corners if len(project_scene(scene(*corners), CAMERA, 9, 9)[1]) else corners[:, [0, 2, 1, 1]]
        triangles, number = project_scene(scene(*front), CAMERA, 9, 9)
        assert number.tolist() == [0] * parts
        assert (triangles.corners[:, :, 2] < 0).all()


def test_light_comes_from_the_eye():
    triangles, _ = project_scene(scene(SQUARE), CAMERA, 9, 9)
    cosine = 2 / np.sqrt(6)
    assert triangles.colour == pytest.approx(np.full((2, 3, 3), 255 * (0.1 + 0.9 * 0.5 * cosine)))
