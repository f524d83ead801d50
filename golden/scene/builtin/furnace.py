"""A closed cube whose light is known in closed form."""

import numpy as np

from golden.scene.builder import SceneBuilder
from golden.scene.builtin.shapes import box
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.scene import Scene

__all__ = ["furnace"]


def furnace(size: int) -> Scene:
    """The unit cube seen from inside, ``size`` x ``size`` patches a face; neighbours share their vertices, edges too.

    Every face sends out a radiance of 1 by itself and reflects half of the light, so all of them shine with 2.
    """
    builder = SceneBuilder("furnace")
    wall = Material(name="wall", diffuse=(0.5,) * 3, emission=(1.0,) * 3)
    for quad in box((0, 0, 0), (1, 1, 1)):
        builder.add(_grid(quad[::-1], size), wall, surface=0)
    return builder.build(camera=Camera(eye=(0.1, 0.2, 0.5), target=(0.9, 0.7, 0.45), fov=70.0))


def _grid(quad: np.ndarray, size: int) -> np.ndarray:
    """A unit square cut into ``size`` x ``size``. Coordinates are k / size on every face alike."""
    step = np.arange(size + 1)
    right, up = quad[1] - quad[0], quad[3] - quad[0]
    points = (quad[0] * size + step[:, None, None] * right + step[:, None] * up) / size
    return np.stack([points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]], axis=2).reshape(-1, 4, 3)
