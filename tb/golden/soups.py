"""Patch soups and ray sets that are hard cases."""

import numpy as np

from golden.cast.rays import Rays
from golden.scene.builder import SceneBuilder
from golden.scene.builtin import builtin_scene
from golden.scene.material import Material
from golden.scene.scene import Scene

__all__ = ["axis_rays", "closed_mesh", "random_rays", "soup"]


def soup(seed: int, count: int = 60) -> Scene:
    """Random parallelograms and triangles: large, tiny, slivers, coplanar, touching and doubled ones."""
    random = np.random.default_rng(seed)
    size = 10.0 ** random.uniform(-4, -0.3, (count, 1))
    first = random.normal(size=(count, 3)) * size
    second = random.normal(size=(count, 3)) * size * 10.0 ** random.uniform(-4, 0, (count, 1))
    corner = random.uniform(size=(count, 3))
    flat = random.random(count) < 0.3
    corner[flat, 2] = np.rint(corner[flat, 2] * 4) / 4
    first[flat, 2] = second[flat, 2] = 0
    quads = np.stack([corner, corner + first, corner + first + second, corner + second], axis=1)
    triangles = np.concatenate([quads[:, :3], quads[:, 2:3]], axis=1)
    builder = SceneBuilder(f"soup {seed}")
    paint = Material(name="paint", diffuse=(0.5, 0.5, 0.5))
    builder.add(quads[::2], paint)
    builder.add(triangles[1::2], paint)
    builder.add(quads[:4], paint)
    builder.add(builtin_scene("furnace:1").vertices[:3], paint)
    return builder.build()


def random_rays(scene: Scene, seed: int, count: int) -> Rays:
    """Rays between random points of the scene's box and around it."""
    random = np.random.default_rng(seed)
    lower, upper = scene.bounds
    origin = random.uniform(lower - 0.3 * scene.size, upper + 0.3 * scene.size, (count, 3))
    return Rays(origin, random.uniform(lower, upper, (count, 3)) - origin)


def axis_rays(scene: Scene, seed: int, count: int) -> Rays:
    """Rays with one or two zero components, many through vertices, edges and cell corners exactly."""
    random = np.random.default_rng(seed)
    points = scene.vertices.reshape(-1, 3)
    origin = points[random.integers(len(points), size=count)].copy()
    direction = random.normal(size=(count, 3))
    zero = random.integers(3, size=count)
    direction[np.arange(count), zero] = 0
    two = random.random(count) < 0.7
    direction[np.flatnonzero(two), (zero[two] + 1) % 3] = 0
    away = random.random(count) < 0.8
    origin[away] -= (direction * random.uniform(0.5, 3, (count, 1)) * scene.size)[away]
    return Rays(origin, direction)


def closed_mesh(name: str) -> Scene:
    """Watertight bodies around the origin: ``box``, ``box of triangles``, ``icosphere``."""
    import trimesh

    if name == "box":
        scene = builtin_scene("furnace:4")
        vertices = scene.vertices - 0.5
    else:
        mesh = trimesh.creation.box() if name == "box of triangles" else trimesh.creation.icosphere(subdivisions=3)
        vertices = mesh.triangles[:, [0, 1, 2, 2]]
    builder = SceneBuilder(name)
    builder.add(vertices, Material(name="paint"))
    return builder.build()
