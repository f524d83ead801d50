"""Hits by Embree are those of the reference, to the last bit."""

import numpy as np
import pytest

from golden.cast.embree import Embree
from golden.cast.grid import Grid
from golden.cast.naive import Naive
from golden.cast.rays import Rays
from golden.light.surface_points import bilinear
from golden.scene.builtin import builtin_scene
from golden.scene.scene import Scene
from tb.golden.soups import random_rays

SCENES = ("cornell", "room1627", "teapot", "gears", *(pytest.param(name, marks=pytest.mark.nightly) for name in (
    "furnace:8", "lobby", "cubes", "man", "phone", "tetra", "balls:1")))


def assert_same(hits, others):
    for name in ("patch", "t", "u", "v"):
        np.testing.assert_array_equal(getattr(hits, name), getattr(others, name), err_msg=name)


@pytest.mark.parametrize("name", SCENES)
def test_nearest_hits_have_the_bits_of_the_grid(name):
    scene = builtin_scene(name)
    rays = random_rays(scene, 20, 20_000)
    assert_same(Embree(scene).nearest(rays), Grid(scene).nearest(rays))


def points_on(scene, patch, random):
    """A random point of each of R patches."""
    u, v = random.random((2, len(patch)))
    return bilinear(scene.vertices[patch], u, v)


@pytest.mark.parametrize("name", ["cornell", "teapot"])
def test_rays_from_surfaces_and_segments_between_them_have_the_hits_of_the_grid(name):
    scene, random = builtin_scene(name), np.random.default_rng(3)
    embree, grid = Embree(scene), Grid(scene)
    patch = random.integers(len(scene), size=(20_000, 2))
    origin, target = (points_on(scene, ends, random) for ends in patch.T)
    direction = random.normal(size=origin.shape)
    direction *= np.sign(np.einsum("rj,rj->r", direction, scene.normals[patch[:, 0]]))[:, None]
    rays = Rays(origin, direction, scene.surface[patch[:, 0]])
    assert_same(embree.nearest(rays), grid.nearest(rays))
    segments = origin, target, scene.surface[patch]
    np.testing.assert_array_equal(embree.occluded(*segments), grid.occluded(*segments))
    np.testing.assert_array_equal(embree.blocked(rays), grid.blocked(rays))
    some = embree.any_hit(rays)
    met = some.patch >= 0
    np.testing.assert_array_equal(met, grid.nearest(rays).patch >= 0)
    points = bilinear(scene.vertices[some.patch[met]], some.u[met], some.v[met])
    np.testing.assert_allclose(rays.origin[met] + some.t[met, None] * rays.direction[met], points,
                               atol=1e-9 * scene.size)


def test_rays_at_corners_edges_and_middles_have_the_hits_of_brute_force():
    scene = builtin_scene("cornell")
    a, b = scene.vertices, np.roll(scene.vertices, -1, axis=1)
    aims = np.concatenate([a.reshape(-1, 3), ((a + b) / 2).reshape(-1, 3), scene.centres])
    origin = np.repeat([[278.0, 273.0, -400.0], [278.0, 273.0, 279.6], scene.bounds[1] * 3], len(aims), axis=0)
    rays = Rays(origin, np.tile(aims, (3, 1)) - origin)
    found, naive = Embree(scene).nearest(rays), Naive(scene).nearest(rays)
    # Where a box stands on the floor two patches are equally near, but for the last bit.
    np.testing.assert_allclose(found.t, naive.t, rtol=1e-15)
    assert (found.patch != naive.patch).sum() <= 2


def test_of_equally_near_patches_the_first_one_wins():
    """Four coincident squares, cut along both diagonals, one of them upside down."""
    square = np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    squares = [np.roll(square, turn, axis=0) for turn in (2, 0, 1)] + [square[::-1]]
    scene = Scene(name="stack", vertices=np.stack(squares),
                  material=np.zeros(4), materials=builtin_scene("cornell").materials)
    across = np.random.default_rng(1).random((1000, 2))
    rays = Rays(np.column_stack([across, np.ones(1000)]), np.tile([0.0, 0, -1], (1000, 1)))
    assert_same(Embree(scene).nearest(rays), Naive(scene).nearest(rays))


@pytest.mark.parametrize("scale", [2.0**-100, 1e-3, 1e6, 2.0**150])
def test_scenes_of_any_size_and_place_and_rays_from_afar_have_the_hits_of_the_grid(scale):
    scene = builtin_scene("man")
    random = np.random.default_rng(4)
    moved = Scene(name="moved", vertices=(scene.vertices + 1000 * scene.size) * scale, material=scene.material,
                  materials=scene.materials, surface=scene.surface)
    aim = random.choice(moved.centres, 5000)
    origin = moved.bounds.mean(axis=0) + random.normal(size=aim.shape) * moved.size * 10.0**random.integers(
        -1, 5, size=(5000, 1))
    rays = Rays(origin, (aim - origin) * random.uniform(0.1, 10, size=(5000, 1)),
                tmax=random.choice([1.0, 3.0, np.inf], 5000))
    found = Embree(moved).nearest(rays)
    assert (found.patch >= 0).sum() > 1000
    assert_same(found, Grid(moved).nearest(rays))


def test_a_ray_goes_on_behind_the_surfaces_that_it_never_hits():
    scene = builtin_scene("cornell")
    lower, upper = scene.bounds
    rays = Rays([(lower + upper) / 2] * 2, [[0, -1, 0]] * 2)
    first = Embree(scene).nearest(rays).patch[0]
    beyond = Rays(rays.origin, rays.direction, target=[scene.surface[first], -1])
    behind = Embree(scene).nearest(beyond)
    assert first >= 0
    assert behind.patch[1] == first
    assert_same(behind, Grid(scene).nearest(beyond))


def test_hits_do_not_depend_on_threads():
    scene = builtin_scene("lobby")
    rays = random_rays(scene, 5, 20_000)
    one = Embree(scene, jobs=1)
    assert_same(one.nearest(rays), one.with_jobs(3).nearest(rays))


@pytest.mark.parametrize("height", [2.0**-26, 2.0**-22, 2.0**-19])
def test_rays_that_start_closer_below_a_plate_than_float32_resolves_hit_it(height):
    """Each starts at a point of its own, on either side of a floor with a plate on both."""
    floor = np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    plate = floor * 0.5 + [0.25, 0.25, 0]
    over = np.array([0, 0, height])
    scene = Scene(name="plates", vertices=np.stack([floor, plate + over, plate[::-1] - over]),
                  material=np.zeros(3), materials=builtin_scene("cornell").materials)
    random = np.random.default_rng(7)
    origin = np.column_stack([random.random((2000, 2)), np.zeros(2000)])
    rays = Rays(origin, random.normal(size=(2000, 3)) * [0.3, 0.3, 1], scene.surface[np.zeros(2000, dtype=int)])
    embree, grid = Embree(scene), Grid(scene)
    found = embree.nearest(rays)
    under = (np.abs(origin[:, :2] - 0.5) < 0.25 - 4 * height).all(axis=1) & (
        np.abs(rays.direction[:, :2]) < np.abs(rays.direction[:, 2:])).all(axis=1)
    assert under.sum() > 300
    np.testing.assert_array_equal(found.patch[under], np.where(rays.direction[under, 2] > 0, 1, 2))
    assert_same(found, grid.nearest(rays))
    np.testing.assert_array_equal(embree.blocked(rays), grid.blocked(rays))
