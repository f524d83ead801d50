"""The rings of E. Haines' Standard Procedural Databases: a pyramid of sets of six interlocking pentagons."""

from itertools import product

import numpy as np

from golden.scene.builder import SceneBuilder
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.scene import Scene
from golden.scene.tessellate import frustum, sphere, square

__all__ = ["pentagons", "pyramid", "rings"]

RADIUS = 0.0735
"""Radius of the tubes where the pentagons' corners are at distance 1: a little less than makes them touch."""

SPREAD = 1 / np.sin(np.pi / 8)
"""Distance between layers: in it a layer grows as a view of 45 degrees does."""

COLORS = ((0.8, 0.12, 0.1), (0.15, 0.65, 0.15), (0.12, 0.2, 0.8), (0.1, 0.65, 0.7), (0.75, 0.15, 0.6), (0.85, 0.7, 0.1))


def pentagons() -> np.ndarray:
    """6 x 5 x 3: the pentagons about the six axes of a dodecahedron, corners at distance 1 from the middle."""
    fifths = 2 * np.pi * np.arange(5) / 5
    flat = np.stack((np.cos(fifths), np.sin(fifths), np.zeros(5)), axis=1)
    tilt = np.arctan(2.0)  # between the axes of two neighbouring faces
    tilted = np.stack((flat[:, 0], flat[:, 1] * np.cos(tilt), flat[:, 1] * np.sin(tilt)), axis=1)
    turn = fifths + np.pi / 5
    x, y = (np.outer(np.cos(turn), tilted[:, 0]) - np.outer(np.sin(turn), tilted[:, 1]),
            np.outer(np.sin(turn), tilted[:, 0]) + np.outer(np.cos(turn), tilted[:, 1]))
    others = np.stack((x, y, np.broadcast_to(tilted[:, 2], x.shape)), axis=2)
    return np.concatenate((flat[None], others))


def pyramid(layers: int) -> np.ndarray:
    """Middles of the sets of rings, N x 3: one in front, then 4, 9, ... in layers along y."""
    centres = []
    for layer in range(layers):
        across = 2.0 * np.arange(layer + 1) - layer
        centres.extend((x, SPREAD * (layer + 1), z) for z, x in product(across, across))
    return np.array(centres)


def rings(size: int) -> Scene:
    """A pyramid of ``size`` layers before a wall."""
    builder = SceneBuilder("rings")
    segments = 8 if size <= 3 else 6
    tubes = [Material(name=f"ring {number}", diffuse=color, specular=(0.15, 0.15, 0.15))
             for number, color in enumerate(COLORS, start=1)]
    scale = 1 / (1 + RADIUS)
    for middle in pyramid(size):
        for corners, tube in zip(middle + scale * pentagons(), tubes, strict=True):
            for corner, following in zip(corners, np.roll(corners, -1, axis=0), strict=True):
                sides = frustum(corner, following, scale * RADIUS, scale * RADIUS, segments=segments)
                builder.add(sides, tube, smooth=True)
                builder.add(sphere(corner, scale * RADIUS, segments=segments), tube, smooth=True)
    back = SPREAD * (size + 1)
    wall = square((0, back, 0), 5 * (size + 1), facing=(0, -1, 0), cuts=8)
    builder.add(wall, Material(name="wall", diffuse=(0.8, 0.8, 0.78)), surface=0)
    middle = np.array((0.0, back / 2, 0.0))
    aside = np.array((1.6 * size, -back, 2.4 * size + 1))
    lamp = square(middle + aside, np.linalg.norm(aside) / 3, facing=-aside, cuts=2)
    builder.add(lamp, Material(name="lamp", emission=(30.0, 29.0, 27.0)), surface=0)
    return builder.build(camera=Camera(eye=(-1.6, -SPREAD, 1.1), target=middle, fov=40), background=(0.25, 0.42, 0.7))
