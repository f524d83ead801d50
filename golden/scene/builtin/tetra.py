"""The pyramid of tetrahedra of E. Haines' Standard Procedural Databases."""

import numpy as np

from golden.scene.builder import SceneBuilder
from golden.scene.camera import Camera
from golden.scene.lights import PointLight
from golden.scene.material import Material
from golden.scene.polygons import as_patches
from golden.scene.scene import Scene

__all__ = ["pyramid", "tetra"]

CORNERS = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)])
"""Every second corner of a cube: a regular tetrahedron."""

FACES = np.array([(0, 1, 2), (3, 2, 1), (2, 3, 0), (1, 0, 3)])


def pyramid(levels: int) -> np.ndarray:
    """``4**levels`` x 3 x 3 integer corners of the triangles, in a cube of edge ``2**levels`` about the origin."""
    centers = np.zeros((1, 3), dtype=np.int64)
    for level in range(1, levels):
        centers = (centers[:, None] + CORNERS * 2 ** (levels - 1 - level)).reshape(-1, 3)
    return (centers[:, None, None] + CORNERS[FACES]).reshape(-1, 3, 3)


def _upright(points: np.ndarray, levels: int) -> np.ndarray:
    """Turns the corner (1, 1, 1) up and scales the pyramid to a cube of edge 2.

    The sums run coordinate by coordinate, so that equal integer points stay equal to the bit.
    """
    x, y, z = np.moveaxis(points / 2 ** (levels - 1), -1, 0)
    return np.stack(((x - y) / np.sqrt(2), (x + y - 2 * z) / np.sqrt(6), (x + y + z) / np.sqrt(3)), axis=-1)


def tetra(size: int) -> Scene:
    """Tetrahedra of ``size`` levels in the air under two point lights."""
    builder = SceneBuilder("tetra")
    red = Material(name="tetrahedron", diffuse=(0.8, 0.2, 0.16))
    builder.add(as_patches(_upright(pyramid(size), size)), red)
    lights = (PointLight(position=(-6.0, -9.0, 10.0), intensity=(500.0, 490.0, 470.0)),
              PointLight(position=(9.0, -4.0, 2.0), intensity=(90.0, 100.0, 120.0)))
    return builder.build(camera=Camera(eye=(-0.9, -4.6, 1.5), target=(0, 0, 0.3), fov=41), lights=lights,
                         background=(0.25, 0.42, 0.7))
