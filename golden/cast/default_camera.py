"""Default cameras of scenes without one."""

from dataclasses import dataclass

import numpy as np

from golden.cast.casters import CastsRays
from golden.cast.rays import Rays
from golden.cast.shared_caster import shared_caster
from golden.scene.camera import Camera
from golden.scene.scene import Scene

__all__ = ["default_camera"]

PROBES = 256
"""Rays from each of the points that test whether the scene is a room."""

WALL_SHARE, OPEN_SHARE = 1 / 3, 1 / 3
"""Least share of a room's probes that hit a wall, and largest share of the probes past the furniture that leave: a room
may lack a side.
"""

OPENING = 0.04
"""Share of the probes that leave through a missing side."""

WALL_DEPTH = 0.05
"""Largest distance of a wall's hit from the scene box, in lengths of its longest side."""

OUTSIDE_FOV, INSIDE_FOV = 40.0, 65.0
ELEVATION, AZIMUTH = 25.0, 35.0
MARGIN = 1.04


def _directions(count: int) -> np.ndarray:
    """Unit vectors distributed uniformly over the sphere: a Fibonacci lattice."""
    step = np.arange(count) + 0.5
    height, turn = 1 - 2 * step / count, np.pi * (1 + 5 ** 0.5) * step
    radius = np.sqrt(1 - height * height)
    return np.stack((radius * np.cos(turn), radius * np.sin(turn), height), axis=1)


@dataclass(frozen=True)
class _Room:
    """A room; ``opening`` is the axis and the sign of its missing side, or None."""

    opening: tuple[int, float] | None


def _room(scene: Scene, caster: CastsRays) -> _Room | None:
    """The room, if most rays from within hit fronts at the border of the scene box.

    A closed box with its backs inside is an object, unless it holds a light.
    """
    low, high = scene.bounds
    signs = np.array([(0, 0, 0), *np.stack(np.meshgrid(*[(-1, 1)] * 3), axis=-1).reshape(-1, 3)])
    points = (low + high) / 2 + signs * (high - low) / 4
    directions = np.tile(_directions(PROBES), (len(points), 1))
    origins = np.repeat(points, PROBES, axis=0)
    hits = caster.nearest(Rays(origins, directions))
    met = hits.patch >= 0
    where = origins[met] + hits.t[met, None] * directions[met]
    at_wall = (np.minimum(where - low, high - where) < WALL_DEPTH * scene.size).any(axis=1)
    walled, escaped = at_wall.sum(), (~met).sum()
    if walled < WALL_SHARE * len(met) or escaped > OPEN_SHARE * (walled + escaped):
        return None
    walls = hits.patch[met][at_wall]
    fronts = np.einsum("ij,ij->i", scene.normals[walls], directions[met][at_wall]) < 0
    if fronts.mean() < 0.5 and not any(material.emits for material in scene.materials):
        return None
    out = directions[~met].mean(axis=0) if escaped > OPENING * len(met) else np.zeros(3)
    axis = int(np.abs(out).argmax())
    return _Room((axis, float(np.sign(out[axis]))) if abs(out[axis]) > 0.5 and axis != _vertical(scene) else None)


def _vertical(scene: Scene) -> int:
    return int(np.abs(scene.up).argmax())


def _through(scene: Scene, opening: tuple[int, float]) -> Camera:
    """A camera outside the missing side, which fills the picture."""
    low, high = scene.bounds
    axis, sign = opening
    half = (high - low) / 2
    centre = (low + high) / 2
    eye = centre.copy()
    extent = max(half[other] for other in range(3) if other != axis)
    eye[axis] += sign * (half[axis] + MARGIN * extent / np.tan(np.radians(OUTSIDE_FOV / 2)))
    return Camera(eye=tuple(eye), target=tuple(centre), up=scene.up, fov=OUTSIDE_FOV)


def _from_inside(scene: Scene, caster: CastsRays) -> Camera:
    """A camera near an upper corner, towards the opposite lower part: the candidate with the widest view."""
    low, high = scene.bounds
    axis = _vertical(scene)
    upward = np.sign(scene.up[axis])
    sides = [other for other in range(3) if other != axis]
    best, camera = -1.0, None
    for inset in (0.06, 0.14, 0.24):
        for corner in ((-1, -1), (1, -1), (-1, 1), (1, 1)):
            share = np.zeros(3)
            share[sides] = np.multiply(corner, 0.5 - inset)
            eye_share, target_share = share.copy(), -0.6 * share
            eye_share[axis], target_share[axis] = 0.12 * upward, -0.15 * upward
            eye, target = ((low + high) / 2 + part * (high - low) for part in (eye_share, target_share))
            candidate = Camera(eye=tuple(eye), target=tuple(target), up=scene.up, fov=INSIDE_FOV)
            directions = _directions(PROBES)
            directions = directions[directions @ candidate.axes[2] > np.cos(np.radians(INSIDE_FOV / 2))]
            hits = caster.nearest(Rays(np.tile(eye, (len(directions), 1)), directions))
            # The geometric mean: an object before the eye hides more than a far wall adds.
            distance = np.minimum(hits.t, np.linalg.norm(high - low))
            openness = float(np.exp(np.log(np.maximum(distance, 1e-9 * scene.size)).mean()))
            if openness > best * 1.01:
                best, camera = openness, candidate
    return camera


def _from_outside(scene: Scene) -> Camera:
    """A three-quarter view from above that frames the sphere around all but the lights."""
    up = np.array(scene.up) / np.linalg.norm(scene.up)
    right = np.eye(3)[0] if abs(up[0]) < 0.9 else np.eye(3)[1]
    right = right - (right @ up) * up
    right /= np.linalg.norm(right)
    toward = np.cross(right, up)
    elevation, azimuth = np.radians(ELEVATION), np.radians(AZIMUTH)
    direction = (np.cos(elevation) * (np.sin(azimuth) * right + np.cos(azimuth) * toward) + np.sin(elevation) * up)
    shown = scene.vertices[~scene.channels("emission").any(axis=1)]
    points = (shown if len(shown) else scene.vertices).reshape(-1, 3)
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = np.linalg.norm(points - centre, axis=1).max()
    eye = centre + MARGIN * radius / np.sin(np.radians(OUTSIDE_FOV / 2)) * direction
    return Camera(eye=tuple(eye), target=tuple(centre), up=scene.up, fov=OUTSIDE_FOV)


def default_camera(scene: Scene, caster=None) -> Camera:
    """The scene's own camera, or a default.

    A room is seen from within, from near a corner towards the opposite lower part, or through its missing side. Any
    other scene (without its lights) is seen as a whole, from outside and above, with +z (y up) or -y (z up) in front. A
    scene is a room if most rays from its middle end at the border of the scene box, on fronts or with a light inside.

    Parameters
    ----------
    caster
        A caster of the scene (``nearest``). Default: that of the default method.
    """
    if scene.camera is not None:
        return scene.camera
    caster = caster or shared_caster(scene)
    room = _room(scene, caster)
    if room is None:
        return _from_outside(scene)
    return _from_inside(scene, caster) if room.opening is None else _through(scene, room.opening)
