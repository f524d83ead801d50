"""Degenerate quads: what the definition of a split patch needs, and that no flat patch is hit.

A patch is split if it is neither strictly convex nor a triangle. Two of these words change no hit and no window:

* "strictly": where all four windings are 0, both orientations are 0, and a patch without orientation is never hit,
  whether it is split or not.
* "nor a triangle": a triangle's second part, with a vertex twice, has the orientation 0, and its first part has the
  planes of the whole: n_30 = -n_02, and n_23 = 0 is inside for every ray. So a triangle may be split.

All other cases matter: a quad that is not convex has hits outside the intersection of its four edges.
"""

from itertools import combinations

import numpy as np
import pytest

from golden.engine.icu.edge_planes import EdgePlanes
from golden.engine.icu.ipbb import ImagePlaneWindows
from golden.engine.icu.sbb import SphericalWindows
from golden.engine.icu.screening import edge_distances, inside
from tb.golden.engine.icu.patches import CONFIG, hemisphere, screen, setup


def degenerate(count=60):
    """Quads with all pairs of vertices repeated, vertices on a line with others or the origin, and vertices at it."""
    random, quads = np.random.default_rng(4), []
    for first, second in combinations(range(4), 2):
        quad = random.integers(-(2**21), 2**21, (count, 4, 3))
        quad[:, second] = quad[:, first]
        quads.append(quad)
        # On one line through the origin: the same V', or the opposite one, from different vertices.
        along = quad.copy()
        along[:, second] = along[:, first] * np.array([-1, 1])[np.arange(count) % 2, None] // 2 * 2
        quads.append(along)
        middle = quad.copy()
        rest = [vertex for vertex in range(4) if vertex not in (first, second)]
        middle[:, second] = (middle[:, rest[0]] + middle[:, rest[1]]) // 2
        quads.append(middle)
    nothing = random.integers(-(2**21), 2**21, (count, 4, 3))
    nothing[np.arange(count), np.arange(count) % 4] = 0
    point = np.repeat(random.integers(-(2**21), 2**21, (count, 1, 3)), 4, axis=1)
    flat = random.integers(-(2**10), 2**10, (count, 4, 3)) * [1, 0, 1]
    return np.concatenate([*quads, nothing, point, flat])


@pytest.fixture(scope="module")
def quads():
    """Directions and planes, split by the definition."""
    directions, planes = setup(degenerate())
    winding = np.sign(np.einsum("pei,pei->pe", planes.planes[:, :4], np.roll(directions, -2, axis=1)))
    alike = (winding == winding[:, :1]).all(axis=1)
    is_triangle = (directions[:, 2] == directions[:, 3]).all(axis=1)
    is_convex = alike & (winding[:, 0] != 0)
    assert (planes.split == (~is_convex & ~is_triangle)).all()
    return directions, planes


def rays_at(directions):
    """Rays at each patch: through its vertices, its edges and its middle, and around them."""
    random = np.random.default_rng(5)
    weights = np.concatenate([np.eye(4), (np.eye(4) + np.roll(np.eye(4), 1, axis=0)) / 2, np.full((1, 4), 0.25),
                              random.dirichlet(np.ones(4), 8)])
    target = np.einsum("kv,pvi->pki", weights, directions.astype(float))
    target += random.integers(-1, 2, target.shape)
    length = np.maximum(np.linalg.norm(target, axis=2, keepdims=True), 1)
    rays = np.rint(target / length * 2**16).astype(np.int64).reshape(-1, 3)
    return np.repeat(np.arange(len(directions)), 17), rays


def test_quads_that_are_not_convex_need_to_be_split(quads):
    directions, planes = quads
    whole = EdgePlanes(planes.planes, planes.orientation, np.zeros_like(planes.split))
    patch, rays = rays_at(directions)
    distances = edge_distances(planes[patch], rays, CONFIG.numbers)
    assert (inside(distances, planes[patch])[0] != inside(distances, whole[patch])[0]).any()


def test_a_patch_without_orientation_is_never_hit(quads):
    directions, planes = quads
    flat = ~planes.orientation.any(axis=1)
    assert flat.sum() > 100
    patch, rays = rays_at(directions)
    assert not inside(edge_distances(planes[patch], rays, CONFIG.numbers), planes[patch])[0][flat[patch]].any()
    for record, windows in ((hemisphere(64, 32), SphericalWindows), (screen(40, 30), ImagePlaneWindows)):
        assert not windows(record, CONFIG).windows(directions, planes).rays[flat].any()
