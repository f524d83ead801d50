"""The sphereflake of E. Haines' Standard Procedural Databases: each ball carries nine of a third of its radius."""

import numpy as np

from golden.scene.builder import SceneBuilder
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.scene import Scene
from golden.scene.tessellate import sphere, square

__all__ = ["balls", "flake"]

RATIO = 1 / 3
SEGMENTS = (24, 16, 12, 8, 6, 4)
"""Patches around a ball of each level."""


def _children() -> np.ndarray:
    """Unit vectors to the nine children of a ball whose own direction is z: six around it, three above."""
    around = np.radians(15 + 60 * np.arange(6))
    above = np.radians(45 + 120 * np.arange(3))
    return np.concatenate((np.stack((np.cos(around), np.sin(around), np.zeros(6)), axis=1),
                           np.stack((np.cos(above), np.sin(above), np.full(3, np.sqrt(2))), axis=1) / np.sqrt(3)))


def _turned(vectors: np.ndarray, to: np.ndarray) -> np.ndarray:
    """K x 3 vectors, turned by each of the shortest turns from z to N directions: N x K x 3."""
    axis = np.stack((-to[:, 1], to[:, 0], np.zeros(len(to))), axis=1)[:, None]
    cosine = to[:, None, 2:]
    across = np.cross(axis, vectors)
    # Half a turn has no shortest one; any axis will do, y is taken.
    opposite = cosine < -0.9999
    bend = 1 / np.where(opposite, 1.0, 1 + cosine)
    return np.where(opposite, vectors * (-1, 1, -1), vectors + across + bend * np.cross(axis, across))


def flake(levels: int) -> list[np.ndarray]:
    """Balls of each level: ``levels + 1`` arrays N x 4 of center and radius. The first ball has radius 1/2."""
    generation, direction = np.array([[0.0, 0.0, 0.0, 0.5]]), np.array([[0.0, 0.0, 1.0]])
    generations = [generation]
    for _ in range(levels):
        direction = _turned(_children(), direction)
        center = generation[:, None, :3] + direction * (generation[:, None, 3:] * (1 + RATIO))
        radius = np.broadcast_to(generation[:, None, 3:] * RATIO, (*center.shape[:2], 1))
        generation = np.concatenate((center, radius), axis=2).reshape(-1, 4)
        direction = direction.reshape(-1, 3)
        generations.append(generation)
    return generations


def balls(size: int) -> Scene:
    """A sphereflake of ``size`` levels on a floor."""
    builder = SceneBuilder("balls")
    glossy = Material(name="ball", diffuse=(0.45, 0.36, 0.22), specular=(0.5, 0.43, 0.32))
    for generation, segments in zip(flake(size), SEGMENTS, strict=False):
        for *center, radius in generation:
            builder.add(sphere(center, radius, segments=segments), glossy, smooth=True)
    floor = square((0, 0, -0.5), 5, cuts=8)
    builder.add(floor, Material(name="floor", diffuse=(0.75, 0.6, 0.35)), surface=0)
    lamp = square((0.8, -1.4, 3.2), 1.6, facing=(-0.8, 1.4, -3.2), cuts=2)
    builder.add(lamp, Material(name="lamp", emission=(13.0, 12.5, 11.5)), surface=0)
    return builder.build(camera=Camera(eye=(2.1, 1.3, 1.7), target=(0, 0, 0), fov=38),
                         background=(0.25, 0.42, 0.7))
