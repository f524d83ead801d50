"""Closed meshes around the origin, in the R frame, and directions that are hard cases for them."""

import numpy as np

from golden.engine.config import Numbers
from golden.engine.icu.vertex_direction import vertex_direction
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.builtin import builtin_scene
from tb.golden.soups import closed_mesh

__all__ = ["MESHES", "aimed_directions", "mesh_around", "random_directions"]

MESHES = ("box", "box of triangles", "icosphere", "tetrahedron", "furnace:6", "cornell room", "mountain in a box")


def mesh_around(name: str, seed: int) -> np.ndarray:
    """N x 4 x 3 int64: the mesh in a random attitude, the origin at a random point inside."""
    random = np.random.default_rng([MESHES.index(name), seed])
    numbers = Numbers()
    vertices = _patches(name)
    middle = vertices.reshape(-1, 3).mean(axis=0)
    inside = middle + random.uniform(-0.15, 0.15, 3) * np.ptp(vertices.reshape(-1, 3), axis=0)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    around = (vertices - inside) @ turn
    return np.rint(around / np.abs(around).max() * random.uniform(0.05, 1) * numbers.vector.high).astype(np.int64)


def random_directions(seed: int, count: int) -> np.ndarray:
    """Directions signed 1.16 over the whole sphere, count x 3."""
    direction = np.random.default_rng(seed).normal(size=(count, 3))
    return np.rint(direction / np.linalg.norm(direction, axis=1, keepdims=True) * 2**16).astype(np.int64)


def aimed_directions(vertices: np.ndarray, seed: int, count: int) -> np.ndarray:
    """Directions at vertices, a third of them exactly (V' itself), and at points of edges, count x 3."""
    random = np.random.default_rng(seed)
    directions, _ = vertex_direction(vertices, Numbers())
    patch, corner = random.integers(len(vertices), size=count), random.integers(4, size=count)
    exact = directions[patch, corner]
    share = np.where(np.arange(count) % 3 == 0, 0, random.uniform(size=count))[:, None]
    start, end = vertices[patch, corner], vertices[patch, (corner + 1) % 4]
    aimed = start + share * (end - start)
    aimed = np.rint(aimed / np.linalg.norm(aimed, axis=1, keepdims=True) * 2**16).astype(np.int64)
    return np.where((np.arange(count) % 3 == 1)[:, None], exact, aimed)


def _patches(name):
    if name in ("box", "box of triangles", "icosphere"):
        return closed_mesh(name).vertices
    if name == "cornell room":
        room = builtin_scene("cornell")
        low, high = room.bounds
        corner = np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]])
        floor, ceiling = (np.column_stack([corner, np.full(4, z)]) for z in (low[2], high[2]))
        walls = [np.array([floor[i], floor[(i + 1) % 4], ceiling[(i + 1) % 4], ceiling[i]]) for i in range(4)]
        return np.array([floor, ceiling, *walls])
    if name == "mountain in a box":
        return _lidded(8)
    if name == "tetrahedron":
        corner = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1.0]])
        return corner[[[0, 1, 2, 2], [0, 3, 1, 1], [0, 2, 3, 3], [1, 3, 2, 2]]]
    return PatchGeometry.of(builtin_scene(name), Numbers()).vertices.astype(float)


def _lidded(size):
    """A rough terrain as floor, and over each of its cells a piece of ceiling and walls down to its border."""
    random = np.random.default_rng(9)
    height = random.uniform(-0.3, -0.2, (size + 1, size + 1))
    grid = np.linspace(-0.5, 0.5, size + 1)
    floor = np.stack([*np.meshgrid(grid, grid, indexing="ij"), height], axis=-1)
    lid = np.stack([*np.meshgrid(grid, grid, indexing="ij"), np.full_like(height, 0.5)], axis=-1)
    patches = []
    for i in range(size):
        for j in range(size):
            a, b, c, d = floor[i, j], floor[i + 1, j], floor[i + 1, j + 1], floor[i, j + 1]
            patches += [[a, b, c, c], [a, c, d, d], [lid[i, j], lid[i + 1, j], lid[i + 1, j + 1], lid[i, j + 1]]]
        for start, end in (((i, 0), (i + 1, 0)), ((i, size), (i + 1, size)), ((0, i), (0, i + 1)),
                           ((size, i), (size, i + 1))):
            patches.append([floor[start], floor[end], lid[end], lid[start]])
    return np.array(patches)
