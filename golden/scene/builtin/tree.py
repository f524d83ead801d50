"""The tree of E. Haines' Standard Procedural Databases, grown after M. Aono and T. L. Kunii (1984)."""

import numpy as np

from golden.scene.builder import SceneBuilder
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.scene import Scene
from golden.scene.tessellate import frustum, sphere, square

__all__ = ["branches", "tree"]

ANGLES = (40.0, 25.0)
"""Degrees by which the two branches of a fork bend away from their stem."""

DIVERGENCE = (90.0, 230.0)
"""Degrees about the stem of the side to which they bend."""

LENGTHS = (0.65, 0.7)
"""Their length in lengths of the stem."""

TAPER = 0.67
"""Radius of a branch's end in radii of its start."""

TRUNK_RADIUS = 0.15
TRUNK_SEGMENTS = 16
LEAST_SEGMENTS = 5


def _forks() -> np.ndarray:
    """2 x 3 x 3: from a branch's frame (z along it, its length 1) to its stem's."""
    frames = []
    for bend, side, length in zip(np.radians(ANGLES), np.radians(DIVERGENCE), LENGTHS, strict=True):
        tilt = np.array([[1, 0, 0], [0, np.cos(bend), -np.sin(bend)], [0, np.sin(bend), np.cos(bend)]])
        turn = np.array([[np.cos(side), -np.sin(side), 0], [np.sin(side), np.cos(side), 0], [0, 0, 1]])
        frames.append(length * turn @ tilt)
    return np.array(frames)


def branches(levels: int) -> list[np.ndarray]:
    """Branches of each level: ``levels + 1`` arrays N x 8 of base, radius, apex, radius. The trunk is 1 high."""
    frame, base, radius = np.eye(3)[None], np.zeros((1, 3)), TRUNK_RADIUS
    generations = []
    for _ in range(levels + 1):
        apex = base + frame[:, :, 2]
        width = np.full(len(base), radius)
        generations.append(np.column_stack((base, width, apex, TAPER * width)))
        frame = (frame[:, None] @ _forks()).reshape(-1, 3, 3)
        base, radius = np.repeat(apex, 2, axis=0), TAPER * radius
    return generations


def tree(size: int) -> Scene:
    """A tree that forks ``size`` times on a field."""
    builder = SceneBuilder("tree")
    bark = Material(name="bark", diffuse=(0.5, 0.34, 0.18))
    for level, generation in enumerate(branches(size)):
        segments = max(LEAST_SEGMENTS, TRUNK_SEGMENTS - 2 * level)
        for branch in generation:
            base, base_radius, apex, apex_radius = branch[:3], branch[3], branch[4:7], branch[7]
            builder.add(frustum(base, apex, base_radius, apex_radius, segments=segments), bark, smooth=True)
            builder.add(sphere(apex, apex_radius, segments=segments), bark, smooth=True)
    field = square((0, 0, 0), 5, cuts=8)
    builder.add(field, Material(name="field", diffuse=(0.22, 0.5, 0.16)), surface=0)
    lamp = square((1.8, -1.9, 4.4), 1.6, facing=(-1.8, 1.9, -3.6), cuts=2)
    builder.add(lamp, Material(name="lamp", emission=(28.0, 26.0, 23.0)), surface=0)
    return builder.build(camera=Camera(eye=(5.2, 0.5, 2.4), target=(0, 0, 1.3), fov=40),
                         background=(0.4, 0.6, 0.9))
