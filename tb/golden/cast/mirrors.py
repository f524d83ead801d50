"""A room with a flat mirror and a thin pane that bodies cross, and the rays of a picture behind them."""

import numpy as np

from golden.cast.grid import Grid
from golden.cast.rays import Rays
from golden.cast.screen import Screen
from golden.scene.builtin.shapes import box
from golden.scene.camera import Camera
from golden.scene.material import Material
from tb.golden.light.scenes import BLACK, rectangle, scene_of

__all__ = ["CAMERA", "MIRROR", "PARTS", "mirror_room", "rays_behind"]

CAMERA = Camera(eye=(0.3, -3.2, 1.4), target=(0, 2, 1.3), up=(0.1, 0.3, 1), fov=75)
MIRROR = Material(name="mirror", specular=(0.9, 0.9, 0.9))
PANE = Material(name="pane", transparent=(0.8, 0.8, 0.8), thin=True)
# The mirror is before the wall, which it hides; the pane stands across the room. A board reaches through each.
PARTS = {
    "mirror": rectangle((-2, 2.5, 0.2), (0, 0, 2.4), (2.2, 0, 0)),
    "pane": rectangle((0.4, 0.5, 0.1), (1.5, 0.4, 0), (0, 0, 2.2)),
    "boards": np.array([rectangle((-1.6, 1.5, 0.9), (0.2, 2, 0.3), (0.6, 0, 0.1)),
                        rectangle((0.9, 0, 1.2), (0.2, 1.2, 0), (0, 0, 0.3))]),
}


def mirror_room(wall: Material = BLACK, mirror: Material = MIRROR, pane: Material = PANE, boards: Material = BLACK,
                more=(), **lamp):
    """The room without a ceiling, of two-sided parts, whose backs are seen, and ``more`` parts; ``lamp`` has properties
    of `SceneBuilder.build`.
    """
    parts = (box((-2, -4, 0), (2, 4, 3), omit=("+z",)), wall), ([PARTS["mirror"]], mirror), ([PARTS["pane"]], pane), (
        PARTS["boards"], boards)
    return scene_of(*((*part, {"two_sided": True}) for part in parts), *more, **lamp)


def rays_behind(scene, camera: Camera, size: tuple[int, int], *, is_mirrored: bool):
    """Rays of a picture that meet the mirror, reflected, or the pane, straight on.

    Returns
    -------
    The rays, and their numbers in the picture.
    """
    screen = Screen(camera=camera, width=size[0], height=size[1])
    rays = screen.rays()
    hits = Grid(scene, 0.25).nearest(rays)
    behind = scene.channels("specular" if is_mirrored else "transparent").any(axis=1)
    field = np.flatnonzero((hits.patch >= 0) & behind[hits.patch])
    patch = hits.patch[field]
    direction = rays.direction[field] / np.linalg.norm(rays.direction[field], axis=1, keepdims=True)
    position = rays.origin[field] + hits.t[field, None] * rays.direction[field]
    if is_mirrored:
        normal = scene.normals[patch]
        direction = direction - 2 * np.einsum("kj,kj->k", direction, normal)[:, None] * normal
    return Rays(position, direction, scene.surface[patch]), field
