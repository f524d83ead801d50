"""Frusta in which fixed point is compared: rooms, soups, origins on patches, next to edges, in corners."""

import numpy as np

from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.frustum import FrustumRecord, hemisphere_record, screen_record
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.builder import SceneBuilder
from golden.scene.builtin import builtin_scene
from golden.scene.camera import Camera
from golden.scene.material import Material
from golden.scene.scene import Scene
from tb.golden.engine.icu.patches import CONFIG
from tb.golden.soups import soup

__all__ = ["WHERE", "hemisphere_in", "long_edge", "room", "screen_in", "soup_case"]

WHERE = ("anywhere", "on a patch", "next to a vertex", "next to an edge")


def hemisphere_in(scene: Scene, origin, normal, rays=(64, 32), source: int = -1) -> tuple[PatchGeometry, FrustumRecord]:
    """The scene's geometry in coordinates that hold the origin, and the hemisphere."""
    geometry = PatchGeometry.of(scene, CONFIG.numbers, origin)
    return geometry, hemisphere_record(Hemisphere(*rays), geometry.coordinates, origin, normal, source=source)


def screen_in(scene: Scene, camera: Camera, size=(64, 48)) -> tuple[PatchGeometry, FrustumRecord]:
    """The scene's geometry in coordinates that hold the eye, and the screen."""
    geometry = PatchGeometry.of(scene, CONFIG.numbers, camera.eye)
    return geometry, screen_record(Screen(camera=camera, width=size[0], height=size[1]), geometry.coordinates)


def room(name: str, seed: int) -> tuple[Scene, PatchGeometry, FrustumRecord]:
    """A built-in scene from a random point in its box."""
    scene, random = builtin_scene(name), np.random.default_rng(seed)
    origin = scene.bounds[0] + random.uniform(0.1, 0.9, 3) * (scene.bounds[1] - scene.bounds[0])
    return scene, *hemisphere_in(scene, origin, random.normal(size=3))


def soup_case(seed: int, where: str) -> tuple[Scene, PatchGeometry, FrustumRecord]:
    """A soup from one of the origins of `WHERE`."""
    scene, random = soup(seed, 40), np.random.default_rng([seed, WHERE.index(where)])
    patch, normal, source = random.integers(len(scene)), random.normal(size=3), -1
    vertices = scene.vertices[patch]
    if where == "anywhere":
        origin = random.uniform(*scene.bounds)
    elif where == "on a patch":
        origin, normal, source = vertices[:3].mean(axis=0), scene.normals[patch], int(scene.surface[patch])
    elif where == "next to a vertex":
        origin = vertices[0] + 1e-4 * random.normal(size=3)
    else:
        origin = vertices[:2].mean(axis=0) + 10.0 ** random.uniform(-6, -1) * random.normal(size=3)
    return scene, *hemisphere_in(scene, origin, normal, source=source)


def long_edge(seed: int, height: float) -> tuple[Scene, PatchGeometry, FrustumRecord]:
    """A floor whose edge passes ``height`` from the origin, in front of a wall."""
    random = np.random.default_rng(seed)
    turn = np.linalg.qr(random.normal(size=(3, 3)))[0]
    floor = np.array([[-0.5, 0, 0], [0.5, 0, 0], [0.45, 0.6, 0], [-0.45, 0.6, 0]])
    wall = np.array([[-0.5, -0.3, -0.4], [0.5, -0.3, -0.4], [0.5, 0.8, -0.4], [-0.5, 0.8, -0.4]])
    builder = SceneBuilder(f"long edge {seed}")
    builder.add(np.array([floor, wall]) @ turn, Material(name="paint"))
    origin = np.array([random.uniform(-0.3, 0.3), height * random.uniform(-1, 1), height * random.uniform(0.1, 1)])
    scene = builder.build()
    return scene, *hemisphere_in(scene, origin @ turn, -turn[2], rays=(128, 64))
