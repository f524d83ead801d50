import numpy as np
import pytest

from golden.cast.grid import Grid
from golden.cast.known_patches import hits_of_patches
from golden.cast.oracle import Oracle
from golden.cast.rays import Rays
from golden.scene.builtin import builtin_scene
from golden.scene.material import Material
from tb.golden.light.scenes import rectangle, scene_of

SQUARE = scene_of((rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), Material(name="grey")))


def hits_of(scene, rays, patch):
    zero = np.zeros(len(rays), dtype=np.int64)
    return hits_of_patches(Oracle(scene), rays, patch, tests=zero, steps=zero)


@pytest.mark.parametrize("name", ["cornell", "lobby", "phone"])
def test_patches_that_are_hit_give_the_casters_own_hits(name):
    scene, random = builtin_scene(name), np.random.default_rng(3)
    rays = Rays(np.tile(scene.bounds.mean(axis=0), (4000, 1)), random.normal(size=(4000, 3)))
    truth = Grid(scene).nearest(rays)
    hits = hits_of(scene, rays, truth.patch)
    np.testing.assert_allclose(hits.t, truth.t, rtol=1e-9)
    for name in ("patch", "u", "v"):
        np.testing.assert_array_equal(getattr(hits, name), getattr(truth, name))


def test_a_ray_just_beside_its_patch_is_on_the_border():
    rays = Rays([(0.5, 1 + 1e-5, 2)], [(0, 0, -1)])
    hits = hits_of(SQUARE, rays, np.array([0]))
    assert (hits.t[0], hits.u[0], hits.v[0]) == (2, pytest.approx(0.5), 1)


@pytest.mark.parametrize("fall", [1e-12, 0.0, -1e-6])
def test_a_ray_that_only_rounding_lets_reach_its_patch_is_not_sent_beyond_it(fall):
    rays = Rays([(-1, 0.5, 1e-6)], [(1, 0, -fall)])
    hits = hits_of(SQUARE, rays, np.array([0]))
    assert 1 <= hits.t[0] <= 2


def test_no_patch_is_no_hit():
    hits = hits_of(SQUARE, Rays([(0, 0, 1)], [(0, 0, 1)]), np.array([-1]))
    assert (hits.patch[0], hits.t[0], hits.u[0], hits.v[0]) == (-1, np.inf, 0, 0)
