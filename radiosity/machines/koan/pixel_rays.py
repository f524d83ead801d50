"""Pixel rays: a picture by ray tracing, and the rays of each of its pixels."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from golden.cast.default_camera import default_camera
from golden.cast.grid import Grid
from golden.cast.rays import Hits, Rays
from golden.cast.screen import Screen
from golden.light.glass import fresnel
from golden.scene.scene import Scene

__all__ = ["PixelRays", "pixel_rays"]

DEPTH, FAINT = 4, 1 / 256
"""Most rays of a path, light rays aside, and the least share of a pixel that a ray is cast for."""

# A light ray ends this share of its length before its light.
_SHORT = 1 - 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class PixelRays:
    """A picture and its rays.

    Parameters
    ----------
    picture
        H x W x 3 uint8.
    rays, hits
        R rays in the order of the pixels, those of a pixel in the order of its tree, and what they hit.
    pixel
        R int64: the pixel of each.
    """

    picture: np.ndarray
    rays: Rays
    hits: Hits
    pixel: np.ndarray


def pixel_rays(scene: Scene, grid: Grid, *, size: tuple[int, int]) -> PixelRays:
    """Trace one primary ray through the middle of each pixel.

    From where it hits, a light ray goes to each light, and a ray in the mirrored and in the refracted direction, as the
    surface has it. Lights are those without an area, and the middles of surfaces that emit. Surfaces are as flat as
    their patches.

    Parameters
    ----------
    scene, grid
        The patches, and the caster of all rays.
    size
        Width and height in pixels.

    Source: Badouel 1991, section 4.1.
    """
    screen = Screen(camera=default_camera(scene, grid), width=size[0], height=size[1])
    light, made = np.zeros((len(screen), 3)), []
    lamps = _lamps(scene)
    waves = [(screen.rays(), np.arange(len(screen)), np.ones((len(screen), 3)))]
    for _ in range(DEPTH):
        waves = [later for wave in waves for later in _wave(scene, grid, lamps, light, made, *wave)]
    rays, hits, pixel = zip(*made, strict=True)
    pixel = np.concatenate(pixel)
    order = np.argsort(pixel, kind="stable")
    joined = [Rays(*(np.concatenate([getattr(one, name) for one in rays])[order] for name in (
        "origin", "direction", "source", "tmax", "target"))),
        Hits(*(np.concatenate([getattr(one, name) for one in hits])[order] for name in (
            "patch", "t", "u", "v", "tests", "steps")))]
    # A pixel of radiance 1 is nearly white.
    shown = np.rint(255 * np.sqrt(light / (1 + light))).astype(np.uint8)
    return PixelRays(picture=shown.reshape(size[1], size[0], 3), rays=joined[0], hits=joined[1], pixel=pixel[order])


def _lamps(scene: Scene) -> list[tuple[np.ndarray, np.ndarray, int]]:
    """Position, intensity and surface of each light; intensities are such that radiances are about 1."""
    emission, found = scene.channels("emission"), []
    for surface in np.unique(scene.surface[emission.any(axis=1)]):
        own = np.flatnonzero((scene.surface == surface) & emission.any(axis=1))
        share = scene.areas[own] / scene.areas[own].sum()
        found.append((share @ scene.centres[own], share @ emission[own] / emission.max(), int(surface)))
    for light in scene.lights:
        position = np.array(light.position) if hasattr(light, "position") else (
            scene.centres.mean(axis=0) - 2 * scene.size * np.array(light.direction))
        found.append((position, np.ones(3), -1))
    return found


def _wave(scene, grid, lamps, light, made, rays, owner, weight) -> Iterator[tuple[Rays, np.ndarray, np.ndarray]]:
    """Cast rays of one generation and their light rays; add what they see to their pixels; yield the next ones."""
    hits = grid.nearest(rays)
    made.append((rays, hits, owner))
    missed, met = np.flatnonzero(hits.patch < 0), np.flatnonzero(hits.patch >= 0)
    _add(light, owner[missed], weight[missed] * scene.background_along(rays.direction[missed]))
    patch, owner, weight = hits.patch[met], owner[met], weight[met]
    direction = rays.direction[met] / np.linalg.norm(rays.direction[met], axis=1, keepdims=True)
    position = rays.origin[met] + hits.t[met, None] * rays.direction[met]
    inward = np.einsum("kj,kj->k", direction, scene.normals[patch])
    normal = scene.normals[patch] * np.where(inward < 0, 1, -1)[:, None]
    surface = scene.surface[patch]
    _add(light, owner, weight * (scene.channels("emission")[patch] > 0))
    diffuse = scene.channels("diffuse")[patch]
    for where, intensity, target in lamps:
        toward = where - position
        cosine = np.einsum("kj,kj->k", toward, normal) / np.linalg.norm(toward, axis=1)
        some = np.flatnonzero((cosine > 0) & diffuse.any(axis=1))
        shadow = Rays(position[some], toward[some], surface[some], np.full(len(some), _SHORT),
                      np.full(len(some), target))
        blocked = grid.nearest(shadow)
        made.append((shadow, blocked, owner[some]))
        clear = some[blocked.patch < 0]
        _add(light, owner[clear], weight[clear] * diffuse[clear] * cosine[clear, None] * intensity)
    specular, transparent = (scene.channels(name)[patch] for name in ("specular", "transparent"))
    index, cosine = scene.channels("refraction_index")[patch], np.abs(inward)
    ratio = np.where(inward < 0, 1 / index, index)
    inside = 1 - ratio**2 * (1 - cosine**2)
    beyond = np.sqrt(np.maximum(inside, 0))
    share = np.where(inside > 0, fresnel(ratio, np.maximum(cosine, 1e-9), beyond), 1.0)[:, None]
    refracted = ratio[:, None] * direction + (ratio * cosine - beyond)[:, None] * normal
    for toward, part in ((direction + 2 * cosine[:, None] * normal, specular + transparent * share),
                         (refracted, transparent * (1 - share))):
        some = np.flatnonzero((weight * part).max(axis=1) > FAINT)
        if len(some):
            yield Rays(position[some], toward[some], surface[some]), owner[some], (weight * part)[some]


def _add(light, owner, values):
    """Add to pixels, of which a wave may have several rays."""
    for channel in range(3):
        light[:, channel] += np.bincount(owner, values[:, channel], len(light))
