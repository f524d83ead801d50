"""A scene is a room up to a third of its probes leaving, whichever parts of its sides are missing."""

import numpy as np
import pytest

from golden.cast.default_camera import default_camera
from golden.cast.grid import Grid
from golden.cast.rays import Rays
from golden.scene.builtin import builtin_scene
from golden.scene.scene import Scene


def cube(*, missing, part):
    """The unit cube of fronts inwards, without the sides +x, +y as ``missing`` names them, and with ``part`` of -x."""
    corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    faces = {"+x": (4, 5, 7, 6), "+y": (2, 6, 7, 3), "-y": (0, 1, 5, 4), "-z": (0, 4, 6, 2), "+z": (1, 3, 7, 5)}
    sides = [corners[list(face)] for name, face in faces.items() if name not in missing]
    sides.append(np.array([(0, 0, 0), (0, part, 0), (0, part, 1), (0, 0, 1)], dtype=float))
    return Scene(name="cube", vertices=np.array(sides), material=np.zeros(len(sides)), up=(0, 0, 1),
                 materials=builtin_scene("furnace:1").materials[:1])


def leaving(scene):
    """The share of 40,000 directions that leaves, from the middle and half the distance to each corner."""
    random = np.random.default_rng(0)
    directions = random.normal(size=(40_000, 3))
    signs = np.array([(0, 0, 0), *np.ndindex(2, 2, 2)]) * 2 - 1
    signs[0] = 0
    origins = 0.5 + 0.25 * signs[random.integers(9, size=len(directions))]
    return (Grid(scene).nearest(Rays(origins, directions)).patch < 0).mean()


@pytest.mark.parametrize(("missing", "part", "bounds", "is_room"), [
    ((), 0.001, (0.15, 0.18), True), (("+y",), 0.35, (0.26, 0.32), True),
    (("+x",), 0.25, (0.27, 0.33), True), (("+x", "+y"), 0.8, (0.345, 0.38), False)])
def test_more_than_a_third_leaves_an_object(missing, part, bounds, is_room):
    scene = cube(missing=missing, part=part)
    assert bounds[0] < leaving(scene) < bounds[1]
    camera = default_camera(scene)
    # The view of an object is from 25 degrees above.
    above = camera.axes[2] @ np.array(scene.up)
    assert (above == pytest.approx(-np.sin(np.radians(25)))) == (not is_room), (above, camera)
