"""Nearest hits are those of Embree, except where single precision does not separate two patches."""

import numpy as np
import pytest

from golden.cast.grid import Grid
from golden.scene.builtin import builtin_scene
from radiosity.benchmarks.embree import Embree
from tb.golden.soups import random_rays

# Single precision keeps coordinates to 2^-24 of the scene's size; a dozen operations on them lose some bits more.
TOLERANCE = 2.0**-18
SCENES = ("cornell", "furnace:8", "lobby", "room1627", "cubes", "man", "phone", "teapot", "tetra", "balls:1", "gears")


def distance_to_edges(scene, rays, patch):
    """Distance of each ray's line from the edges of a patch, in scene units."""
    corner = scene.vertices[patch]
    along = rays.direction / np.linalg.norm(rays.direction, axis=1, keepdims=True)
    start = corner - rays.origin[:, None]
    start = start - np.einsum("rcj,rj->rc", start, along)[..., None] * along[:, None]
    edge = np.roll(start, -1, axis=1) - start
    length2 = np.maximum(np.einsum("rcj,rcj->rc", edge, edge), 1e-300)
    share = np.clip(-np.einsum("rcj,rcj->rc", start, edge) / length2, 0, 1)
    return np.linalg.norm(start + share[..., None] * edge, axis=2).min(axis=1)


def depth(scene, rays, patch):
    """Distance along each ray to a patch's plane, in scene units."""
    normal = scene.normals[patch]
    along = np.einsum("rj,rj->r", normal, rays.direction / np.linalg.norm(rays.direction, axis=1, keepdims=True))
    return np.einsum("rj,rj->r", normal, scene.vertices[patch, 0] - rays.origin) / along, np.abs(along)


@pytest.mark.parametrize("name", SCENES)
def test_nearest_hits_are_those_of_embree(name):
    scene = builtin_scene(name)
    rays = random_rays(scene, 20, 100_000)
    ours, theirs = Grid(scene).nearest(rays).patch, Embree(scene).nearest(rays)
    differ = np.flatnonzero(ours != theirs)
    rays, ours, theirs = rays[differ], ours[differ], theirs[differ]
    tolerance = TOLERANCE * scene.size
    on_edge = np.zeros(len(differ), dtype=bool)
    for patch in (ours, theirs):
        met = patch >= 0
        on_edge[met] |= distance_to_edges(scene, rays[met], patch[met]) < tolerance
    same_depth = np.zeros(len(differ), dtype=bool)
    both = np.flatnonzero((ours >= 0) & (theirs >= 0))
    (first, slope_1), (second, slope_2) = (depth(scene, rays[both], patch[both]) for patch in (ours, theirs))
    same_depth[both] = np.abs(first - second) < tolerance / np.minimum(slope_1, slope_2)
    assert (on_edge | same_depth).all(), f"{(~(on_edge | same_depth)).sum()} of {len(differ)} differences unexplained"
    assert len(differ) < 100
