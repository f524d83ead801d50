"""Patches and directions that are hard cases of the intersection."""

import numpy as np

from golden.engine.config import Config, Numbers
from golden.engine.icu.edge_planes import edge_planes
from golden.engine.icu.screening import edge_distances, inside
from golden.engine.icu.vertex_direction import vertex_direction

__all__ = ["directions_at", "meeting_pairs", "r_patches", "scene_patches"]

KINDS = ("anywhere", "near the axis", "sliver", "on the horizon", "around the axis", "through the origin", "degenerate")


def r_patches(random: np.random.Generator, count: int, numbers: Numbers) -> np.ndarray:
    """Quads and triangles of all `KINDS` in rotation: count x 4 x 3 int64, R frame."""
    kind = np.arange(count) % len(KINDS)

    def of(name):
        return kind == KINDS.index(name)

    corner = random.normal(size=(count, 1, 3)) * 2.0 ** random.uniform(-6, -1.5, (count, 1, 1))
    first, second = random.normal(size=(2, count, 1, 3)) * 2.0 ** random.uniform(-8, -1, (count, 1, 1))
    corner[of("near the axis"), :, :2] *= 2.0 ** random.uniform(-16, -2, (of("near the axis").sum(), 1, 1))
    second[of("sliver")] *= 2.0 ** random.uniform(-16, -4, (of("sliver").sum(), 1, 1))
    around = of("around the axis")
    first[around], second[around] = [0.3, 0.02, 0.01], [-0.03, 0.25, 0.01]
    corner[around] = -(first + second)[around] / 2 + corner[around] * [0.2, 0.2, 1]
    corner[of("through the origin")] = -(0.3 * first + 0.4 * second)[of("through the origin")]
    scale = random.uniform(0.3, 1, (count, 2, 1))
    patch = np.concatenate([corner, corner + first, corner + first * scale[:, :1] + second * scale[:, 1:],
                            corner + second], axis=1)
    patch[of("on the horizon"), :2, 2] = 0
    patch[of("degenerate")] *= random.random((of("degenerate").sum(), 4, 3)) > 0.3
    patch[::3, 3] = patch[::3, 2]
    limit = numbers.vector.high
    return np.clip(np.rint(patch * 2.0**numbers.vector_fraction), -limit, limit).astype(np.int64)


def scene_patches(random: np.random.Generator, count: int, origin: np.ndarray, numbers: Numbers) -> np.ndarray:
    """The same kinds around an origin: count x 4 x 3 int64, G coordinates."""
    grown = r_patches(random, count, numbers) << (numbers.scene_bits - numbers.vector_fraction)
    return np.clip(origin + grown, 0, numbers.scene.high)


def directions_at(random: np.random.Generator, patches: np.ndarray, numbers: Numbers) -> np.ndarray:
    """Ray directions, count x 3: at a point of each patch, and of every fourth at a vertex, at an edge, or anywhere."""
    count = len(patches)
    weights = random.dirichlet(np.ones(4), count)
    weights[1::4] = np.eye(4)[random.integers(4, size=len(weights[1::4]))]
    weights[2::4, 2:] = 0
    target = np.einsum("pk,pki->pi", weights, patches)
    target[3::4] = random.normal(size=target[3::4].shape)
    target[~target.any(axis=1)] = [0, 0, 1]
    unit = target / np.linalg.norm(target, axis=1, keepdims=True)
    return numbers.direction.encode(unit, "direction")


def meeting_pairs(random: np.random.Generator, count: int, config: Config) -> tuple[np.ndarray, np.ndarray]:
    """Patches (R frame) and directions, each of which meets its patch."""
    numbers = config.numbers
    patches, directions = np.empty((0, 4, 3), dtype=np.int64), np.empty((0, 3), dtype=np.int64)
    while len(patches) < count:
        more = r_patches(random, 2 * count + 16, numbers)
        at = directions_at(random, more, numbers)
        planes = edge_planes(vertex_direction(more, numbers)[0], numbers)
        meets = inside(edge_distances(planes, at, numbers), planes)[0]
        patches, directions = np.concatenate([patches, more[meets]]), np.concatenate([directions, at[meets]])
    return patches[:count], directions[:count]
