"""A regular array of boxes: the stand-in for the thesis' scene of that name."""

import numpy as np

from golden.scene.builder import SceneBuilder
from golden.scene.builtin.shapes import box
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.scene import Scene

__all__ = ["cubes"]

COUNT = 8
SIDE = 0.5
LOWER, UPPER = (-4.0, -5.0, -1.5), (12.0, 11.0, 10.0)

SHELL = Material(name="shell", diffuse=(0.75, 0.75, 0.75))
LIGHT = Material(name="light", diffuse=(0.60, 0.60, 0.60), emission=(9.0, 8.5, 7.8))


def cubes() -> Scene:
    """8 x 8 x 8 boxes, half as wide as their pitch, afloat in a closed room; 3079 patches.

    The light is a one-sided sheet a little before a wall: the ceiling sees all of the array.
    """
    builder = SceneBuilder("cubes")
    builder.add(box(LOWER, UPPER)[:, ::-1], SHELL)
    x = LOWER[0] + 0.2
    builder.add([(x, -4.0, 0.5), (x, 6.0, 0.5), (x, 6.0, 9.5), (x, -4.0, 9.5)], LIGHT)
    cube = box((-SIDE / 2,) * 3, (SIDE / 2,) * 3)
    middles = np.arange(COUNT) + 0.5
    for z in middles:
        for y in middles:
            row = np.stack([middles, np.full(COUNT, y), np.full(COUNT, z)], axis=-1)
            builder.add(cube + row[:, None, None], _paint(y / COUNT, z / COUNT))
    return builder.build(camera=Camera(eye=(-2.8, -4.3, 8.7), target=(4.4, 4.1, 3.3), fov=56.0))


def _paint(across: float, up: float) -> Material:
    """Warm at the top, cold at the bottom, greener towards the back."""
    diffuse = 0.1 + 0.75 * up, 0.15 + 0.6 * across, 0.8 - 0.65 * up
    return Material(name=f"paint {across:.2f} {up:.2f}", diffuse=diffuse)
