"""Drawn shadow rays, and frusta of them."""

import numpy as np

from golden.cast.shadow_rays import ShadowRays
from golden.engine.frustum.shadow_record import position, shadow_record
from golden.engine.icu.inverse_distance import encode
from golden.engine.scene.patch_geometry import PatchGeometry
from tb.golden.engine.icu.patches import CONFIG
from tb.golden.soups import soup

__all__ = ["drawn_frustum", "drawn_rays"]


def drawn_frustum(seed, scene=None, *, bits=5, share=0.7):
    """Patches, and a frustum from a random point with rays in a share of its positions."""
    random, scene = np.random.default_rng(seed), scene or soup(seed, 40)
    geometry = PatchGeometry.of(scene, CONFIG.numbers)
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    axes[0] *= np.linalg.det(axes)
    slopes = random.integers(-1 << 16, 1 << 16, (int(share * 2 * 4**bits), 2))
    _, first = np.unique(position(slopes, bits, CONFIG.numbers), return_index=True)
    end = encode((2.0**20 / random.uniform(0.01, 1, len(first))).astype(np.int64), np.array(-20), CONFIG.numbers)
    origin = geometry.coordinates.integers(random.uniform(*scene.bounds))
    return geometry, *shadow_record(geometry.coordinates, origin, axes, bits, slopes=slopes[first], end=end)


def drawn_rays(scene, count, seed, *, lights=4):
    """Rays from points of few patches, of those that shine if there are any, to points of all patches by area."""
    random = np.random.default_rng(seed)
    shining = np.flatnonzero(scene.channels("emission").max(axis=1) > 0)
    light = random.choice(shining if len(shining) else len(scene), lights)
    target = random.choice(len(scene), count, p=scene.areas / scene.areas.sum())
    u, v = random.random((2, lights + count, 1))
    corners = scene.vertices[np.concatenate([light, target])]
    points = (1 - v) * ((1 - u) * corners[:, 0] + u * corners[:, 1]) + v * ((1 - u) * corners[:, 3] + u * corners[:, 2])
    return ShadowRays(points=points[:lights], surfaces=scene.surface[light], light=random.integers(lights, size=count),
                      targets=points[lights:], normals=scene.normals[target]), scene.surface[target]
