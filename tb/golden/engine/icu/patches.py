"""Patches in the R frame and frusta that are hard cases of windows and intersection."""

import numpy as np

from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.config import Config, Numbers
from golden.engine.frustum import FrustumRecord, hemisphere_record, screen_record
from golden.engine.icu.edge_planes import EdgePlanes, edge_planes
from golden.engine.icu.screening import cones, inside_cones
from golden.engine.icu.vertex_direction import vertex_direction
from golden.engine.scene.g_coordinates import GCoordinates
from golden.scene.camera import Camera

__all__ = ["CONFIG", "KINDS", "brute_hits", "hard_patches", "hemisphere", "meeting", "screen", "setup"]

CONFIG = Config()
KINDS = ("anywhere", "near the axis", "tiny and slivers", "through the axis", "on the horizon", "wide", "degenerate")
_UNIT = GCoordinates(corner=np.zeros(3), scale=1.0, numbers=Numbers(), bounds=np.array([[0.1] * 3, [0.9] * 3]))


def hemisphere(azimuths: int, polars: int) -> FrustumRecord:
    """A hemisphere in the middle of the cube whose R frame has the cube's axes."""
    return hemisphere_record(Hemisphere(azimuths, polars), _UNIT, (0.5, 0.5, 0.5), (0, 0, 1), axes=np.eye(3))


def screen(width: int, height: int, fov: float = 60.0) -> FrustumRecord:
    """A screen in the middle of the cube."""
    camera = Camera(eye=(0.5, 0.5, 0.5), target=(0.5, 0.9, 0.5), fov=fov)
    return screen_record(Screen(camera=camera, width=width, height=height), _UNIT)


def hard_patches(kind: str, seed: int, count: int) -> np.ndarray:
    """``count`` convex quads and triangles, count x 4 x 3 int64 in the R frame."""
    random = np.random.default_rng([KINDS.index(kind), seed])
    size = 2.0 ** random.uniform(-8, -0.5, (count, 1, 1))
    corner = random.normal(size=(count, 1, 3)) * 2.0 ** random.uniform(-6, -1.5, (count, 1, 1))
    first, second = random.normal(size=(2, count, 1, 3)) * size
    if kind == "near the axis":
        corner[..., :2] *= 2.0 ** random.uniform(-16, -2, (count, 1, 1))
        first, second = first / 8, second / 8
    elif kind == "tiny and slivers":
        first *= 2.0 ** random.uniform(-12, 0, (count, 1, 1))
        second *= 2.0 ** random.uniform(-16, 0, (count, 1, 1))
    scale = random.uniform(0.05, 2, (count, 2, 1))
    patches = np.concatenate(
        [corner, corner + first, corner + first * scale[:, :1] + second * scale[:, 1:], corner + second], axis=1)
    if kind == "through the axis":
        patches[..., :2] -= (patches[:, random.integers(4), None, :2] + patches[:, random.integers(4), None, :2]) / 2
    elif kind == "on the horizon":
        patches[:, 1:, 2] *= 2.0 ** -random.uniform(0, 20, (count, 1))
        patches[: count // 2, :2, 2] = 0
    elif kind == "wide":
        low = random.uniform(-0.2, 0.2, (count, 1, 1)) * [0, 0, 1]
        square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * 0.5
        turn = np.linalg.qr(random.normal(size=(count, 3, 3)))[0]
        patches = (square + random.normal(size=(count, 1, 3)) * [0.3, 0.3, 0] + low) @ turn
    patches[::4, 3] = patches[::4, 2]
    patches = np.clip(np.rint(patches * 2.0**22), -(2**23) + 1, 2**23 - 1).astype(np.int64)
    if kind == "degenerate":
        patches = np.where(random.random(patches.shape) < 0.3, 0, patches)
        patches[: count // 8, 1] = patches[: count // 8, 0]
    return patches


def setup(vertices: np.ndarray) -> tuple[np.ndarray, EdgePlanes]:
    """V' and edge planes of vertices in the R frame."""
    directions, _ = vertex_direction(vertices, CONFIG.numbers)
    return directions, edge_planes(directions, CONFIG.numbers)


def meeting(planes: EdgePlanes, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All pairs of a patch and a direction inside its edges."""
    owner, turned = cones(planes)
    parts = [inside_cones(turned[start:start + 64], directions) for start in range(0, len(owner), 64)]
    cone = np.concatenate([np.full(0, 0)] + [part[0] + 64 * number for number, part in enumerate(parts)])
    return owner[cone], np.concatenate([np.full(0, 0)] + [part[1] for part in parts])


def brute_hits(planes: EdgePlanes, directions: np.ndarray) -> np.ndarray:
    """How many patches each direction meets."""
    return np.bincount(meeting(planes, directions)[1], minlength=len(directions))
