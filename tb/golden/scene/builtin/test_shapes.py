"""The building blocks of the built-in scenes."""

import numpy as np
import pytest

from golden.scene.builtin.shapes import FACES, box, cap, framed, frames, loft, placed, rounded, tube
from golden.scene.tessellate import revolution, sphere
from tb.golden.scene.builtin.solids import area_vectors, is_closed, volume


def test_box_is_closed_with_fronts_outwards():
    patches = box((1, 2, 3), (2, 4, 6))
    assert is_closed(patches)
    assert volume(patches) == 6
    for face, vector in zip(FACES, area_vectors(patches), strict=True):
        axis = "xyz".index(face[1])
        assert np.sign(vector[axis]) == (1 if face[0] == "+" else -1)
        assert np.count_nonzero(vector) == 1


def test_box_leaves_out_the_named_faces():
    patches = box((0, 0, 0), (1, 1, 1), omit=("-z", "+x"))
    whole = box((0, 0, 0), (1, 1, 1))
    np.testing.assert_array_equal(patches, whole[[0, 2, 3, 5]])


@pytest.mark.parametrize("depth", [None, 0.5])
def test_framed_keeps_the_border_and_the_front(depth):
    quad = box((0, 0, 0), (4, 3, 2))[5]
    patches = framed(quad, border=0.5, depth=depth)
    assert len(patches) == (5 if depth is None else 9)
    pit = 0 if depth is None else 3 * 2 * depth
    rest = box((0, 0, 0), (4, 3, 2), omit=("+z",))
    assert is_closed(np.concatenate([rest, patches]))
    assert volume(np.concatenate([rest, patches])) == pytest.approx(24 - pit)


def test_loft_to_a_pole_gives_triangles_and_is_closed():
    ring = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=np.float64)
    pyramid = np.concatenate([loft([ring, np.full((4, 3), (0.5, 0.5, 3.0))]), ring[None, ::-1]])
    assert is_closed(pyramid)
    assert volume(pyramid) == pytest.approx(1)
    assert (pyramid[:4, 3] == pyramid[:4, 2]).all()
    needle = loft([np.full((4, 3), (0.5, 0.5, -3.0)), ring, np.full((4, 3), (0.5, 0.5, 3.0))])
    assert is_closed(needle)
    assert volume(needle) == pytest.approx(2)
    assert (needle[:, 3] == needle[:, 2]).all()


@pytest.mark.parametrize("count", [4, 5, 6, 7, 20])
def test_cap_covers_a_ring_and_shares_its_edges(count):
    ring = revolution([(1, 0), (1, 1)], segments=count)
    top, bottom = cap(ring[:, 3]), cap(ring[::-1, 0])
    assert is_closed(np.concatenate([ring, top, bottom]))
    assert volume(np.concatenate([ring, top, bottom])) == pytest.approx(count / 2 * np.sin(2 * np.pi / count))
    assert np.linalg.norm(area_vectors(top), axis=1).min() > 0


def test_rounded_rectangles_of_different_size_loft_to_planar_quads():
    lower = rounded(4, 3, radius=1.0, steps=5)
    upper = rounded(3.5, 2.5, radius=0.75, steps=5, height=1)
    quads = loft([lower, upper])
    fourth = np.einsum("ni,ni->n", quads[:, 3] - quads[:, 0], np.cross(quads[:, 1] - quads[:, 0],
                                                                      quads[:, 2] - quads[:, 0]))
    np.testing.assert_allclose(fourth, 0, atol=1e-15)
    assert area_vectors(cap(lower))[:, 2].sum() == pytest.approx(12 - 4 + 20 * np.sin(np.pi / 10) / 2)


def test_frames_stay_square_to_the_path():
    s = np.linspace(0, 9, 60)
    path = np.stack([np.cos(s), np.sin(s), 0.2 * s], axis=1)
    right, up = frames(path)
    tangent = np.gradient(path, axis=0)
    for vectors in right, up:
        np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1)
        np.testing.assert_allclose(np.einsum("ni,ni->n", vectors, tangent), 0, atol=1e-12)
    np.testing.assert_allclose(np.einsum("ni,ni->n", right, up), 0, atol=1e-12)


def test_tube_points_outwards_and_is_open_only_at_its_ends():
    path = np.stack([np.zeros(5), np.arange(5.0) ** 2, np.arange(5.0)], axis=1)
    patches = tube(path, radius=0.1, sides=6)
    assert len(patches) == 2 * 6 * 4
    first, last = patches[:12:2, 0], patches[-12::2][:, 0]
    end = patches[-11::2, 2]
    assert len(first) == len(last) == len(end) == 6
    closed = np.concatenate([patches, cap(first[::-1]), cap(end)])
    assert is_closed(closed)
    assert volume(closed) > 0


def test_placed_keeps_shared_points_equal_to_the_bit():
    ball = sphere((0, 0, 0), 0.3, segments=17)
    patches = placed(ball, scale=(1, 0.7, 1.3), turn=33.0, axis=(0.3, -0.5, 0.8), at=(7, 11, 13))
    assert is_closed(patches)
    assert volume(patches) == pytest.approx(volume(ball) * 0.7 * 1.3)


def test_placed_lays_the_z_axis_along_the_given_one():
    point = placed([(0, 0, 2.0)], axis=(3, 0, 4), turn=70.0, at=(1, 1, 1))
    np.testing.assert_allclose(point, [(1 + 1.2, 1, 1 + 1.6)])


def test_quarter_turns_are_exact():
    np.testing.assert_array_equal(placed([(1, 2, 3)], turn=-90.0), [(2, -1, 3)])
    np.testing.assert_array_equal(placed([(1, 2, 3)], turn=180.0), [(-1, -2, 3)])
