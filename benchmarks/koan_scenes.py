"""Stand-ins for the scenes of the report on KOAN: its databases as ours generate them, under as many point lights."""

from dataclasses import dataclass, replace

import numpy as np

from golden.cast.default_camera import default_camera
from golden.scene.builtin import builtin_scene
from golden.scene.lights import PointLight
from golden.scene.scene import Scene

__all__ = ["KOAN_SCENES", "KoanScene", "koan_scene"]

# Sides of the view on which lights are, as multiples of its right and its up.
_SIDES = ((-1.0, 1.0), (1.0, 0.7), (0.0, 1.6))


@dataclass(frozen=True, kw_only=True)
class KoanScene:
    """A scene of the source's table 2.

    Parameters
    ----------
    ours
        Our scene and its size.
    lights
        Point lights of the database of E. Haines.
    polygons, rays, kilobytes
        The source's.
    """

    ours: tuple[str, int]
    lights: int
    polygons: int
    rays: int
    kilobytes: int


KOAN_SCENES = {
    "Teapot": KoanScene(ours=("teapot", 9), lights=2, polygons=3751, rays=1_397_473, kilobytes=793),
    "Mountain": KoanScene(ours=("mountain", 6), lights=1, polygons=9920, rays=1_722_415, kilobytes=2031),
    "Rings4": KoanScene(ours=("rings", 4), lights=3, polygons=18002, rays=1_872_991, kilobytes=4632),
    "Tetra9": KoanScene(ours=("tetra", 9), lights=1, polygons=262_111, rays=303_239, kilobytes=36189)}


def koan_scene(name: str) -> Scene:
    """The stand-in for a scene of `KOAN_SCENES`, without surfaces that emit."""
    source = KOAN_SCENES[name]
    kind, size = source.ours
    scene = builtin_scene(f"{kind}:{size}")
    dark = ~scene.channels("emission").any(axis=1)
    scene = replace(scene.with_parts(dark), lights=())
    camera = default_camera(scene)
    right, up, _ = camera.axes
    away = np.linalg.norm(np.subtract(camera.eye, camera.target))
    lights = tuple(PointLight(position=tuple(camera.eye + away * (x * right + y * up)), intensity=(1.0, 1.0, 1.0))
                   for x, y in _SIDES[:source.lights])
    return replace(scene, lights=lights)
