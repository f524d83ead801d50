import numpy as np
import pytest

from golden.cast.rays import Hits
from golden.light import lattice
from golden.light.elements import Elements
from golden.scene.builtin import builtin_scene
from golden.scene.refine import refine
from tb.golden.light.scenes import BLACK, rectangle, scene_of

FLOOR = rectangle((0, 0, 0), (2, 0, 0), (0, 1, 0))
TRIANGLE = np.array([(0, 0, 1), (3, 0, 1), (1, 2, 2), (1, 2, 2)], dtype=float)
TRAPEZOID = np.array([(-1, 0, 4), (3, 0, 4), (2, 2, 4), (0, 2, 4)], dtype=float)


# Quads and triangles, two of the four patches two-sided.
MIXED = scene_of((FLOOR, BLACK), (TRIANGLE, BLACK, {"two_sided": True}), (TRAPEZOID, BLACK, {"two_sided": True}),
                 (np.add(TRIANGLE, (0, 0, 5)), BLACK))


@pytest.fixture
def bare(monkeypatch):
    """Nodes exactly on the corners of elements."""
    monkeypatch.setattr(lattice, "INSET", 0.0)
    monkeypatch.setattr(lattice, "LIFT", 0.0)
    monkeypatch.setattr(lattice, "CLEAR", 0.0)


@pytest.fixture(params=[9.0, 0.7, 0.4])
def refinement(request):
    return refine(MIXED, max_edge=request.param)


@pytest.fixture
def elements(refinement):
    return Elements(MIXED, refinement)


def test_backs_of_two_sided_patches_follow_the_fronts(refinement, elements):
    count = len(refinement.parent)
    behind = np.flatnonzero(MIXED.two_sided[refinement.parent])
    assert len(elements) == count + len(behind)
    np.testing.assert_array_equal(elements.patch[:count], refinement.parent)
    np.testing.assert_array_equal(elements.patch[count:], refinement.parent[behind])
    np.testing.assert_array_equal(elements.vertices[count:], elements.vertices[behind])
    np.testing.assert_array_equal(elements.normal[count:], -elements.normal[behind])
    np.testing.assert_array_equal(elements.area, refinement.scene.areas[np.append(np.arange(count), behind)])
    np.testing.assert_array_equal(elements.triangle, MIXED.is_triangle[elements.patch])


def test_elements_are_the_means_of_their_corners(elements):
    np.testing.assert_allclose(elements.of_corners.sum(axis=1), 1, rtol=0, atol=1e-14)
    assert elements.of_corners.shape == (len(elements), len(elements.lattice))
    corners = np.where(elements.triangle, 3, 4)
    np.testing.assert_array_equal(np.count_nonzero(elements.of_corners.toarray() > 1e-9, axis=1), corners)


@pytest.mark.usefixtures("bare")
def test_the_nodes_of_an_element_stand_on_its_corners(elements):
    share = np.where(elements.triangle[:, None], [1 / 3, 1 / 3, 1 / 3, 0], 0.25)
    centre = np.einsum("ck,ckx->cx", share, elements.vertices)
    np.testing.assert_allclose(elements.of_corners @ elements.lattice.position, centre, rtol=0, atol=1e-12)
    np.testing.assert_allclose(elements.of_corners @ elements.lattice.normal, elements.normal, rtol=0, atol=1e-12)


def test_points_of_an_element_have_its_number_and_lie_among_its_corners(elements):
    random = np.random.default_rng(5)
    patch, (u, v) = random.integers(len(MIXED), size=2000), random.random((2, 2000))
    front = (random.random(2000) < 0.5) | ~MIXED.two_sided[patch]
    number = elements.number(patch, u, v, front)
    np.testing.assert_array_equal(elements.patch[number], patch)
    np.testing.assert_array_equal(np.einsum("kj,kj->k", elements.normal[number], MIXED.normals[patch]) > 0, front)
    sample = elements.at(patch, u, v, front)
    own = elements.of_corners[number].toarray() > 1e-9
    assert (np.take_along_axis(own, sample.nodes, axis=1) | (sample.weights < 1e-9)).all()


def test_the_back_of_a_one_sided_patch_is_no_element(refinement, elements):
    number = elements.number(np.arange(4), np.full(4, 0.3), np.full(4, 0.3), np.zeros(4, dtype=bool))
    assert (number >= 0).tolist() == [False, True, True, False]
    assert (number[1:3] >= len(refinement.parent)).all()


def test_rays_see_the_elements_of_the_sides_that_they_hit(elements):
    random = np.random.default_rng(7)
    patch = random.integers(-1, len(MIXED), size=500).astype(np.int32)
    # At the ends and the middles of sides too, and along some patches.
    u, v = random.choice([0, 0.5, 1, *random.random(5)], (2, 500))
    direction = random.normal(size=(500, 3))
    direction[::9] = (FLOOR[1] - FLOOR[0]) + (FLOOR[2] - FLOOR[1])
    hits = Hits(patch=patch, t=np.ones(500), u=u, v=v, tests=np.ones(500, dtype=int), steps=np.ones(500, dtype=int))
    front = np.einsum("kj,kj->k", direction, MIXED.normals[patch]) < 0
    seen, number = elements.seen(direction, hits), elements.number(np.maximum(patch, 0), u, v, front)
    assert (seen == np.where(patch < 0, -1, number)).all()
    assert {(0, True), (0, False), (1, False)} <= set(zip(patch.tolist(), front.tolist(), strict=True))


def test_every_element_of_a_quad_has_a_cell_of_its_own(elements):
    cells = elements.position.cell[~elements.triangle]
    assert len(np.unique(cells)) == len(cells)
    assert elements.position.cell.max() < elements.lattice.cells


def test_a_closer_lattice_covers_its_elements_and_agrees_with_the_coarse_one_at_their_corners():
    scene = scene_of((FLOOR, BLACK), (TRAPEZOID, BLACK, {"two_sided": True}))
    refinement = refine(scene, max_edge=0.4)
    elements = Elements(scene, refinement)
    chosen = np.random.default_rng(6).permutation(len(elements))[:15]
    assert (chosen >= len(refinement.parent)).any()
    refined = elements.refined(chosen, 4)
    assert refined.cells == 15 * 16
    for a, b, corner in ((0, 0, 0), (1, 0, 1), (0, 1, 2), (1, 1, 3)):
        fine = refined.at(np.arange(15), np.full(15, float(a)), np.full(15, float(b)))
        nodes = fine.nodes[np.arange(15), corner]
        np.testing.assert_allclose(fine.weights[np.arange(15), corner], 1)
        coarse = elements.position.nodes[chosen, corner]
        np.testing.assert_allclose(refined.position[nodes], elements.lattice.position[coarse], rtol=0, atol=1e-9)
        np.testing.assert_allclose(refined.normal[nodes], elements.lattice.normal[coarse], rtol=0, atol=1e-12)


def test_closer_elements_side_by_side_share_their_nodes():
    scene = scene_of((FLOOR, BLACK))
    elements = Elements(scene, refine(scene, max_edge=0.1))
    assert len(elements.refined(np.arange(len(elements)), 4)) == (20 * 4 + 1) * (10 * 4 + 1)


def test_a_scene_of_curved_and_flat_patches_has_finite_nodes():
    scene = builtin_scene("teapot:3")
    elements = Elements(scene, refine(scene, max_edge=scene.size / 20))
    assert np.isfinite(elements.lattice.position).all()
    np.testing.assert_allclose(np.linalg.norm(elements.lattice.normal, axis=1), 1, rtol=0, atol=1e-12)
    np.testing.assert_allclose(elements.of_corners.sum(axis=1), 1, rtol=0, atol=1e-12)
