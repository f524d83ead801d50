import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.base.errors import InputError
from golden.scene.material import Material
from golden.scene.refine import MOST_ELEMENTS, refine
from golden.scene.scene import Scene
from tb.lib.schedules import SETTINGS

TRAPEZOID = [(0, 0, 0), (4, 0, 0), (2.5, 1, 0), (1, 1, 0)]
TRIANGLE = [(0, 0, 1), (3, 0, 1), (0, 2, 1), (0, 2, 1)]


def scene(*patches, **properties):
    patches = np.array(patches, dtype=float)
    return Scene(name="test", vertices=patches, material=np.zeros(len(patches)),
                 materials=(Material(name="grey", diffuse=(0.5, 0.5, 0.5)),), **properties)


def longest_edge(vertices):
    return np.linalg.norm(np.roll(vertices, -1, axis=1) - vertices, axis=2).max()


def bilinear(corners, u, v):
    a, b, c, d = corners
    return (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d


@settings(SETTINGS, max_examples=60)
@given(max_edge=st.floats(0.05, 5), seed=st.integers(0, 1000))
def test_elements_keep_the_edge_bound_and_the_area_and_are_as_few_as_that_takes(max_edge, seed):
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    whole = scene(np.array(TRAPEZOID) @ turn, np.array(TRIANGLE) @ turn)
    refined = refine(whole, max_edge=max_edge)
    assert longest_edge(refined.scene.vertices) <= max_edge * (1 + 1e-9)
    areas = np.bincount(refined.parent, refined.scene.areas)
    assert np.allclose(areas, whole.areas, rtol=1e-12)
    fold = np.sqrt(3.25)
    fewest = [np.ceil(4 / max_edge - 1e-9), np.ceil(fold / max_edge - 1e-9)], [np.ceil(13 ** 0.5 / max_edge - 1e-9)] * 2
    assert np.array_equal(refined.cuts.counts, np.maximum(fewest, 1))


@settings(SETTINGS, max_examples=60)
@given(max_area=st.floats(0.002, 5))
def test_elements_keep_the_area_bound(max_area):
    refined = refine(scene(TRAPEZOID, TRIANGLE), max_area=max_area)
    assert refined.scene.areas.max() <= max_area * (1 + 1e-6)


def test_an_area_bound_cuts_a_square_into_the_fewest_squares():
    square = scene([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    assert refine(square, max_area=1 / 16).cuts.counts.tolist() == [[4, 4]]
    assert refine(square, max_area=1).cuts.counts.tolist() == [[1, 1]]


def test_without_bounds_every_patch_is_one_element():
    whole = scene(TRAPEZOID, TRIANGLE)
    refined = refine(whole)
    assert np.array_equal(refined.scene.vertices, whole.vertices)
    assert refined.parent.tolist() == refined.first.tolist() == [0, 1]


def test_elements_face_as_their_patch_and_keep_its_properties():
    whole = scene(TRAPEZOID, TRIANGLE, surface=[7, 3], smooth=[5, 5], two_sided=[True, False])
    refined = refine(whole, max_edge=0.3)
    assert np.allclose(refined.scene.normals, whole.normals[refined.parent])
    for name in ("surface", "smooth", "two_sided", "material"):
        assert np.array_equal(getattr(refined.scene, name), getattr(whole, name)[refined.parent])
    assert np.array_equal(refined.scene.is_triangle, whole.is_triangle[refined.parent])


def test_triangle_elements_are_congruent():
    refined = refine(scene(TRIANGLE), max_edge=0.5)
    edges = np.linalg.norm(np.diff(refined.scene.vertices[:, [0, 1, 2, 0]], axis=1), axis=2)
    assert np.allclose(np.sort(edges, axis=1), np.sort(edges[0]))


@pytest.mark.parametrize("turn", range(4))
def test_a_quad_and_a_triangle_over_one_edge_meet_in_equal_corners(turn):
    a, b, across, off = np.random.default_rng(3).normal(size=(4, 3))
    quad = np.roll([a, b, b + across, a + across], turn, axis=0)
    apex = (a + b) / 2 + 0.1 * off
    triangle = np.array([b, a, apex, apex])
    refined = refine(scene(quad, triangle), max_edge=np.linalg.norm(b - a) / 6.5)
    sets = [set(map(tuple, refined.scene.vertices[refined.parent == patch].reshape(-1, 3))) for patch in (0, 1)]
    assert len(sets[0] & sets[1]) == 8


@pytest.mark.parametrize("opposite", [False, True])
def test_two_quads_over_one_edge_meet_in_equal_corners(opposite):
    random = np.random.default_rng(9)
    a, b, across, up = random.normal(size=(4, 3))
    one = np.array([a, b, b + across, a + across])
    two = np.array([b, a, a + up, b + up]) if opposite else np.array([a, b, b + up, a + up])
    refined = refine(scene(one, two), max_edge=np.linalg.norm(b - a) / 9.5)
    sets = [set(map(tuple, refined.scene.vertices[refined.parent == patch].reshape(-1, 3))) for patch in (0, 1)]
    assert len(sets[0] & sets[1]) == 11


@pytest.mark.parametrize("patch", [TRAPEZOID, TRIANGLE])
@pytest.mark.parametrize("max_edge", [0.2, 0.9, 10])
def test_locate_finds_the_element_in_which_the_point_lies(patch, max_edge):
    whole = scene(TRIANGLE, patch)
    refined = refine(whole, max_edge=max_edge)
    u, v = np.random.default_rng(1).random((2, 3000))
    element = refined.locate(np.full(3000, 1), u, v)
    assert (refined.parent[element] == 1).all()
    corners = refined.scene.vertices[element]
    point = bilinear(np.array(patch, dtype=float)[:, None], u[:, None], v[:, None])
    ahead = np.roll(corners, -1, axis=1) - corners
    side = np.cross(ahead, point[:, None] - corners)[..., 2]
    assert side.min() > -1e-12


@pytest.mark.parametrize(("bounds", "message"), [
    ({"max_edge": 0}, "refinement: Max edge must be a finite value above 0, not 0"),
    ({"max_edge": float("nan")}, "refinement: Max edge must be a finite value above 0, not nan"),
    ({"max_area": -1.0}, "refinement: Max area must be a finite value above 0, not -1.0"),
    ({"max_area": float("inf")}, "refinement: Max area must be a finite value above 0, not inf"),
])
def test_bounds_that_are_none_are_refused(bounds, message):
    with pytest.raises(InputError) as error:
        refine(scene(TRAPEZOID), **bounds)
    assert str(error.value) == message


@pytest.mark.parametrize("bounds", [{"max_edge": 1e-9}, {"max_area": 1e-300}, {"max_edge": 1e-200}, {"max_edge": 5e-4}])
def test_absurdly_many_elements_are_refused(bounds):
    with pytest.raises(InputError, match=f"elements or more, at most {MOST_ELEMENTS} are allowed"):
        refine(scene(TRAPEZOID), **bounds)
