"""The meshed gears of E. Haines' Standard Procedural Databases."""

from itertools import product

import numpy as np

from golden.scene.builder import SceneBuilder
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.scene import Scene
from golden.scene.tessellate import square

__all__ = ["gears", "outline", "train"]

TEETH = 36
OUTER = 0.995
"""Radius to the tips of the teeth, less than 1 so that they do not touch the next gear."""

INNER = 0.9
TIP = 0.16
ROOT = 0.28
"""Half widths of a tooth at its tip and its root, in teeth: a little less than makes neighbours touch."""

COLORS = ((0.75, 0.2, 0.15), (0.85, 0.6, 0.12), (0.3, 0.6, 0.2), (0.15, 0.55, 0.6), (0.2, 0.3, 0.75),
          (0.55, 0.25, 0.65), (0.7, 0.7, 0.68))


def outline(turn: float) -> np.ndarray:
    """``4 * TEETH`` x 2 corners of a gear of radius 1, counter-clockwise, four for each tooth: tip, tip, root, root.

    ``turn`` is the direction of the first tooth in radians.
    """
    step = 2 * np.pi / TEETH
    angle = turn + step * (np.arange(TEETH)[:, None] + (-TIP, TIP, ROOT, 1 - ROOT)).ravel()
    radius = np.tile((OUTER, OUTER, INNER, INNER), TEETH)
    return np.stack((radius * np.cos(angle), radius * np.sin(angle)), axis=1)


def train(count: int) -> list[tuple[tuple[int, int, int], np.ndarray, float, float]]:
    """The gears of ``count`` along each edge: their numbers, top centers, radius and turn."""
    radius = 1 / (count - (count - 1) * (1 - INNER) / 2)
    apart = radius * (1 + INNER)
    gear = []
    for index in product(range(count), repeat=3):
        x, y, z = index
        center = np.array((radius - 1 + apart * x, radius - 1 + apart * y, 1 - z / count))
        gear.append((index, center, radius, np.pi / TEETH * (sum(index) % 2)))
    return gear


def _face(corners: np.ndarray, center: np.ndarray) -> np.ndarray:
    """Patches of a face seen from its front: each tooth, and a kite from it and the next gap to the center."""
    tooth = corners.reshape(TEETH, 4, 3)
    root = np.roll(tooth[:, 3], 1, axis=0)
    teeth = np.stack((root, tooth[:, 0], tooth[:, 1], tooth[:, 2]), axis=1)
    kites = np.stack((np.broadcast_to(center, root.shape), root, tooth[:, 2], tooth[:, 3]), axis=1)
    return np.concatenate((teeth, kites))


def _gear(center: np.ndarray, radius: float, turn: float, thickness: float) -> tuple[np.ndarray, np.ndarray]:
    """Patches of one gear and their surfaces: 0 top, 1 bottom, then each side its own."""
    flat = radius * outline(turn)
    top = center + np.pad(flat, ((0, 0), (0, 1)))
    down = np.array((0.0, 0.0, thickness))
    bottom = top - down
    sides = np.stack((top, bottom, np.roll(bottom, -1, axis=0), np.roll(top, -1, axis=0)), axis=1)
    faces = _face(top, center), _face(bottom, center - down)[:, [0, 3, 2, 1]]
    surface = np.concatenate((np.repeat((0, 1), [len(face) for face in faces]), 2 + np.arange(len(sides))))
    return np.concatenate((*faces, sides)), surface


def gears(size: int) -> Scene:
    """``size`` gears along each edge of a block over a mirroring ground; every fifth lets some light through."""
    builder = SceneBuilder("gears")
    thickness = min(0.1, 1 / (2 * size))
    for (x, y, z), center, radius, turn in train(size):
        number = (2 * x + 3 * y + z) % len(COLORS)
        color = np.array(COLORS[number])
        if (4 * x + 2 * y + z) % 5 == 0:
            material = Material(name=f"glass {number}", diffuse=tuple(0.3 * color), specular=(0.08, 0.08, 0.08),
                                transparent=tuple(0.75 * color), refraction_index=1.1)
        else:
            material = Material(name=f"gear {number}", diffuse=tuple(0.9 * color), specular=(0.08, 0.08, 0.08))
        patches, surface = _gear(center, radius, turn, thickness)
        builder.add(patches, material, surface=surface)
    ground = square((0, 0, 0), 3.4, cuts=8)
    builder.add(ground, Material(name="ground", diffuse=(0.4, 0.35, 0.28), specular=(0.35, 0.35, 0.35)), surface=0)
    lamp = square((-1.4, 0.5, 3.6), 1.5, facing=(1.4, -0.5, -3.1), cuts=2)
    builder.add(lamp, Material(name="lamp", emission=(15.0, 14.5, 13.7)), surface=0)
    return builder.build(camera=Camera(eye=(-1.2, -2.5, 2.9), target=(0, 0, 0.4), fov=43),
                         background=(0.25, 0.42, 0.7))
