"""The fractal mountain with four glass balls of E. Haines' Standard Procedural Databases, here as an island."""

import numpy as np

from golden.scene.builder import SceneBuilder
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.polygons import as_patches
from golden.scene.scene import Scene
from golden.scene.tessellate import sphere, square

__all__ = ["crystal", "mountain", "terrain"]

DIMENSION = 2.2
"""Fractal dimension of the terrain."""

SEED = 79
BALL = 0.17
SEGMENTS = 24


def _heights(levels: int) -> np.ndarray:
    """Heights over a square of ``2**levels`` cells by L. Carpenter's midpoint displacement; the border stays at 0."""
    random = np.random.default_rng(SEED)
    roughness = np.sqrt(4 ** (1 - 1 / (DIMENSION - 1)) - 1)
    heights = np.zeros((2, 2))
    for level in range(levels):
        rise = roughness * 0.5**level
        count = 2 * len(heights) - 1
        finer = np.zeros((count, count))
        finer[::2, ::2] = heights
        finer[1::2, ::2] = (heights[:-1] + heights[1:]) / 2
        finer[::2, 1::2] = (heights[:, :-1] + heights[:, 1:]) / 2
        finer[1::2, 1::2] = (finer[1::2, :-2:2] + finer[1::2, 2::2]) / 2
        noise = rise * random.standard_normal((count, count))
        noise[1::2, 1::2] *= np.sqrt(2)
        noise[::2, ::2] = 0
        noise[[0, -1]] = noise[:, [0, -1]] = 0
        heights = finer + noise
    return heights


def terrain(levels: int) -> np.ndarray:
    """``2 * 4**levels`` x 3 x 3 triangles over the square from (-1, -1) to (1, 1), the front above."""
    heights = _heights(levels)
    steps = np.linspace(-1, 1, len(heights))
    points = np.stack((*np.meshgrid(steps, steps, indexing="ij"), heights), axis=2)
    a, b, c, d = points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]
    return np.stack((np.stack((a, b, c), axis=2), np.stack((a, c, d), axis=2)), axis=2).reshape(-1, 3, 3)


def crystal(center) -> np.ndarray:
    """4 x 4 centers and radii of balls in a tetrahedron about ``center``, each just clear of the others."""
    corners = np.array(((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))) / np.sqrt(2)
    x, y, z = corners.T
    upright = np.stack(((x - y) / np.sqrt(2), (x + y - 2 * z) / np.sqrt(6), (x + y + z) / np.sqrt(3)), axis=1)
    return np.column_stack((center + BALL * upright, np.full(4, 0.995 * BALL)))


def mountain(size: int) -> Scene:
    """Terrain of ``size`` levels in the sea, four glass balls in the air before it."""
    builder = SceneBuilder("mountain")
    rock = Material(name="rock", diffuse=(0.5, 0.44, 0.34))
    builder.add(as_patches(terrain(size)), rock, smooth=False)
    glass = Material(name="glass", specular=(0.08, 0.08, 0.08), transparent=(0.9, 0.9, 0.9), refraction_index=1.5)
    for *center, radius in crystal((-1.05, -0.5, 0.72)):
        builder.add(sphere(center, radius, segments=SEGMENTS), glass, smooth=True)
    sea = square((0, 0, 0.02), 3.6, cuts=8)
    water = Material(name="water", diffuse=(0.03, 0.1, 0.14), specular=(0.25, 0.28, 0.3))
    builder.add(sea, water, surface=0)
    lamp = square((1.4, -1.6, 3.2), 1.2, facing=(-1.4, 1.6, -3.2), cuts=2)
    builder.add(lamp, Material(name="lamp", emission=(42.0, 39.0, 34.0)), surface=0)
    return builder.build(camera=Camera(eye=(-3.3, -2.6, 2.2), target=(0, 0, 0.35), fov=37),
                         background=(0.45, 0.62, 0.9))
