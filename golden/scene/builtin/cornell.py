"""The Cornell box after the measurements that Cornell University's Program of Computer Graphics published."""

import numpy as np

from golden.scene.builder import SceneBuilder
from golden.scene.builtin.shapes import loft
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.scene import Scene

__all__ = ["cornell"]

WHITE = Material(name="white", diffuse=(0.885809, 0.698859, 0.666422))
GREEN = Material(name="green", diffuse=(0.105421, 0.377980, 0.076425))
RED = Material(name="red", diffuse=(0.570068, 0.043014, 0.044371))
# The lamp's own reflectance is measured too: 0.78 at all wavelengths.
LIGHT = Material(name="light", diffuse=(0.78, 0.78, 0.78), emission=(18.387, 10.987, 2.754))

HEIGHT = 548.8
FLOOR = np.array([[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]])
CEILING = np.array([[556.0, HEIGHT, 0.0], [556.0, HEIGHT, 559.2], [0.0, HEIGHT, 559.2], [0.0, HEIGHT, 0.0]])
LAMP = np.array([[343.0, HEIGHT, 227.0], [343.0, HEIGHT, 332.0], [213.0, HEIGHT, 332.0], [213.0, HEIGHT, 227.0]])
# Corners of the blocks' tops in x and z, counter-clockwise from above (z counts downwards on such a plan).
SHORT_BLOCK = 165.0, ((130.0, 65.0), (82.0, 225.0), (240.0, 272.0), (290.0, 114.0))
TALL_BLOCK = 330.0, ((423.0, 247.0), (265.0, 296.0), (314.0, 456.0), (472.0, 406.0))


def cornell() -> Scene:
    """The box in millimetres, y up, with its two blocks, its lamp and the published camera; 20 patches.

    As in the data the lamp fills a hole in the ceiling, which is cut into four trapezoids around it, so that ceiling,
    walls and lamp share their vertices. The left wall's four measured corners do not lie in a plane: two triangles.
    The front is open. All patches are one-sided: their backs are never seen, and the blocks have no bottoms.
    """
    builder = SceneBuilder("cornell")
    builder.add(FLOOR, WHITE)
    builder.add(loft([CEILING, LAMP]), WHITE, surface=0)
    builder.add(LAMP, LIGHT)
    builder.add([[FLOOR[3], FLOOR[2], CEILING[2], CEILING[1]]], WHITE)
    builder.add([[FLOOR[2], FLOOR[1], CEILING[3], CEILING[2]]], GREEN)
    builder.add([[FLOOR[0], FLOOR[3], CEILING[1], CEILING[1]], [FLOOR[0], CEILING[1], CEILING[0], CEILING[0]]], RED,
                smooth=True)
    for height, corners in (SHORT_BLOCK, TALL_BLOCK):
        rings = np.array([[(x, y, z) for x, z in corners] for y in (0.0, height)])
        builder.add(np.concatenate([loft(rings), rings[1:]]), WHITE)
    fov = 2 * np.degrees(np.arctan2(0.025 / 2, 0.035))
    camera = Camera(eye=(278.0, 273.0, -800.0), target=(278.0, 273.0, 0.0), up=(0.0, 1.0, 0.0), fov=fov)
    return builder.build(camera=camera, up=(0.0, 1.0, 0.0))
