"""Rays that Embree casts differ from those of grid only where single precision does not separate two patches."""

from collections import Counter

import numpy as np
import pytest

from benchmarks.casting import diffuse_rays
from benchmarks.float32_causes import CAUSES, float32_causes
from golden.cast.embree import Embree
from golden.cast.grid import Grid
from golden.cast.rays import Hits, Rays
from golden.scene.builder import SceneBuilder
from golden.scene.builtin import builtin_scene
from golden.scene.material import Material
from tb.golden.soups import random_rays

# Rays of each scene in a commit and at night, ten million in all.
SCENES = {"cornell": (20_000, 2_000_000), "room1627": (40_000, 4_000_000), "tetra": (20_000, 2_000_000),
          "balls:2": (20_000, 2_000_000)}
# At most so many of a million rays differ: the band is 2^-19 of the scene's size.
MOST = 10


def check_differences(name, count):
    scene = builtin_scene(name)
    embree, grid = Embree(scene), Grid(scene)
    causes = Counter()
    for seed in range(0, count, 500_000):
        first = random_rays(scene, seed, min(count - seed, 500_000) // 2)
        for rays in (first, diffuse_rays(scene, grid, first)):
            found, expected = embree.nearest(rays), grid.nearest(rays)
            causes += float32_causes(scene, rays, found, expected)
            same = found.patch == expected.patch
            for field in ("t", "u", "v"):
                assert getattr(found, field)[same].tobytes() == getattr(expected, field)[same].tobytes()
    assert causes["unexplained"] == 0, causes
    assert causes.total() <= 1 + MOST * count / 1e6, causes


@pytest.mark.parametrize("name", SCENES)
def test_differences_are_within_the_band_of_single_precision(name):
    check_differences(name, SCENES[name][0])


@pytest.mark.nightly
@pytest.mark.parametrize("name", SCENES)
def test_differences_of_ten_million_rays_are_within_the_band_of_single_precision(name):
    check_differences(name, SCENES[name][1])


def ball(rings):
    """A closed ball of ``4 * rings * (rings - 1)`` triangles, made of rings of twice as many points."""
    across, down = np.meshgrid(np.arange(2 * rings) * np.pi / rings, np.arange(rings + 1) * np.pi / rings)
    # A pole is one point, and so is where a ring meets itself.
    ring = np.where((down == 0) | (down == np.pi), 0, np.sin(down))
    points = np.stack([ring * np.cos(across), ring * np.sin(across), np.cos(down)], axis=-1)
    a, b, c, d = points[:-1], points[1:], np.roll(points[1:], -1, axis=1), np.roll(points[:-1], -1, axis=1)
    lower, upper = np.stack([a, b, c, c], axis=2)[:-1], np.stack([a, c, d, d], axis=2)[1:]
    builder = SceneBuilder("ball")
    builder.add(np.concatenate([lower.reshape(-1, 4, 3), upper.reshape(-1, 4, 3)]), Material(name="paint"))
    return builder.build()


@pytest.mark.parametrize(("rings", "count"), [
    (12, 20_000), pytest.param(158, 4_000_000, marks=pytest.mark.nightly)])
def test_no_ray_passes_through_a_closed_ball(rings, count):
    """Nearest and any hit, at random and at corners and middles of edges; of 158 rings there are 99,224 triangles."""
    scene, random = ball(rings), np.random.default_rng(rings)
    assert len(scene) == 4 * rings * (rings - 1)
    embree = Embree(scene)
    corners = scene.vertices[:, :3]
    aims = np.concatenate([corners.reshape(-1, 3), ((corners + np.roll(corners, 1, axis=1)) / 2).reshape(-1, 3)])
    for aimed in (random.normal(size=(count // 2, 3)), random.choice(aims, count // 2)):
        origin = random.uniform(-0.4, 0.4, size=aimed.shape)
        rays = Rays(origin, aimed - origin)
        assert (embree.nearest(rays).patch >= 0).all()
        assert embree.blocked(rays).all()


def test_a_difference_has_the_cause_that_was_made():
    """A square hit at its start, at its border, in its middle edge-on, beside one as near, and for no reason."""
    square = np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    builder = SceneBuilder("squares")
    builder.add(np.stack([square, square - np.array([0, 0, 2.0**-21])]), Material(name="paint"))
    scene = builder.build()
    down, low = (0.0, 0, -1), (1.0, 0, -1e-3)
    cases = [((0.5, 0.5, 1e-6), down, 1e-6, 0.5, -1), ((0.5, 1e-6, 1), down, 1, 1e-6, -1),
             ((-0.5, 0.5, 1e-3), low, 1, 0.5, -1), ((0.5, 0.5, 1), down, 1, 0.5, 1),
             ((0.5, 0.5, 1), down, 1, 0.5, -1)]
    count, (origin, direction, t, v, other) = len(cases), zip(*cases, strict=True)
    none, half = np.zeros(count, dtype=int), np.full(count, 0.5)
    hits = [Hits(patch=np.array(patch), t=np.where(np.array(patch) < 0, np.inf, t), u=half, v=np.array(v), tests=none,
                 steps=none) for patch in (none, other)]
    found = float32_causes(scene, Rays(origin, direction), *hits)
    assert found == dict.fromkeys(CAUSES, 1)
