"""Nearest hits are those of Embree, except where single precision does not separate two patches."""

import numpy as np
import pytest

from golden.cast.embree import Embree
from golden.cast.grid import Grid
from golden.cast.rays import Rays
from golden.light.surface_points import bilinear
from golden.scene.builtin import builtin_scene
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
    ours, theirs = Grid(scene).nearest(rays).patch, Embree(scene).nearest(rays).patch
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


def points_on(scene, patch, random):
    """A random point in the interior of each of R patches."""
    u, v = random.uniform(0.05, 0.95, (2, len(patch)))
    return bilinear(scene.vertices[patch], u, v)


# Of 20,000 each, the rays from surfaces, and the segments between them, that differ: single precision.
@pytest.mark.parametrize(("name", "rays_differ", "segments_differ"), [
    ("cornell", 0, 0), ("lobby", 2, 2), ("room1627", 5, 5), ("teapot", 5, 5)])
def test_differences_of_rays_from_surfaces_are_few(name, rays_differ, segments_differ):
    scene, random = builtin_scene(name), np.random.default_rng(3)
    embree, grid = Embree(scene), Grid(scene)
    patch = random.integers(len(scene), size=(20_000, 2))
    origin, target = (points_on(scene, ends, random) for ends in patch.T)
    direction = random.normal(size=origin.shape)
    direction *= np.sign(np.einsum("rj,rj->r", direction, scene.normals[patch[:, 0]]))[:, None]
    rays = Rays(origin, direction, scene.surface[patch[:, 0]])
    theirs, ours = embree.nearest(rays), grid.nearest(rays)
    same = theirs.patch == ours.patch
    assert (~same).sum() <= rays_differ
    met = same & (ours.patch >= 0)
    np.testing.assert_allclose(theirs.t[met], ours.t[met], rtol=1e-6)
    # A segment in the plane of a ceiling touches the edges of the walls below it.
    along = target - origin
    sine = np.abs(np.einsum("rj,rej->re", along, scene.normals[patch])) / np.linalg.norm(along, axis=1)[:, None]
    some = sine.min(axis=1) > 1e-3
    segments = origin[some], target[some], scene.surface[patch[some]]
    assert (embree.occluded(*segments) != grid.occluded(*segments)).sum() <= segments_differ


def test_a_ray_goes_on_behind_the_surfaces_that_it_never_hits():
    scene = builtin_scene("cornell")
    lower, upper = scene.bounds
    rays = Rays([[0.5, 0.5, 0.5] * upper + [0.5, 0.5, 0.5] * lower] * 2, [[0, -1, 0]] * 2)
    first = Embree(scene).nearest(rays).patch[0]
    behind = Embree(scene).nearest(Rays(rays.origin, rays.direction, target=[scene.surface[first], -1])).patch
    assert first >= 0
    assert behind[1] == first
    assert behind[0] == Grid(scene).nearest(Rays(rays.origin[:1], rays.direction[:1],
                                                 source=scene.surface[[first]])).patch[0]
