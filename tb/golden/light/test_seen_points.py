"""Points that rays see: positions, sides and shading normals."""

import numpy as np
import pytest

from golden.cast.rays import Hits, Rays
from golden.light.seen_points import SeenPoints
from golden.light.surface_points import corner_normals
from golden.scene.builtin import builtin_scene


def test_points_of_a_facetted_ball_lie_on_it_and_face_the_rays():
    scene = builtin_scene("balls:0")
    random = np.random.default_rng(5)
    count = 64
    patch = random.integers(len(scene), size=count).astype(np.int32)
    u, v = random.random((2, count))
    corner = scene.vertices[patch]
    shares = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=1)
    truth = np.einsum("kc,kcx->kx", shares, corner)
    origin = truth + random.normal(size=(count, 3))
    t = random.uniform(0.5, 2, count)
    rays = Rays(origin, (truth - origin) / t[:, None])
    hits = Hits(patch=patch, t=t, u=u, v=v, tests=np.ones(count, dtype=int), steps=np.ones(count, dtype=int))
    met = np.arange(3, count, 2)
    points, direction, front = SeenPoints(scene).at(rays, hits, met)
    np.testing.assert_allclose(points.position, truth[met], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1)
    assert (points.patch == patch[met]).all()
    facing = np.einsum("kx,kx->k", rays.direction, scene.normals[patch])[met]
    assert (front == (facing < 0)).all()
    assert 0 < front.sum() < len(met)
    normal = np.einsum("kc,kcx->kx", shares, corner_normals(scene)[patch])[met]
    normal *= np.where(front, 1, -1)[:, None] / np.linalg.norm(normal, axis=1, keepdims=True)
    assert points.normal == pytest.approx(normal, abs=1e-12)
