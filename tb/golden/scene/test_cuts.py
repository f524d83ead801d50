"""Cells between knots, and uniform ones."""

import numpy as np

from golden.scene.cuts import Cuts
from golden.scene.refine import refine
from tb.golden.light.scenes import BLACK, rectangle, scene_of

COUNTS = np.array([[3, 2], [2, 3], [4, 1]])
KNOTS = {1: (np.array([0, 0.1, 1.0]), np.array([0, 0.25, 0.5, 1.0])), 2: (np.array([0, 0.5, 0.6, 0.9, 1]),
                                                                          np.array([0.0, 1]))}


def test_places_are_the_inverse_of_cells():
    cuts = Cuts(COUNTS, KNOTS)
    patch = np.repeat(np.arange(3), 41)
    place = np.tile(np.linspace(0, 1, 41), 3)
    for axis in (0, 1):
        cells = cuts.cells(patch, axis, place)
        assert (cells >= 0).all()
        assert (cells <= COUNTS[patch, axis]).all()
        np.testing.assert_allclose(cuts.places(patch, axis, cells), place, atol=1e-14)


def test_cells_begin_at_the_knots():
    cuts = Cuts(COUNTS, KNOTS)
    for patch, own in KNOTS.items():
        for axis, knots in enumerate(own):
            np.testing.assert_allclose(cuts.cells(np.full(len(knots), patch), axis, knots), np.arange(len(knots)),
                                       atol=1e-13)
    assert cuts.cells(np.array([0]), 0, np.array([0.5])).tolist() == [1.5]
    assert cuts.has_knots(np.arange(3)).tolist() == [False, True, True]


def test_elements_between_knots_cover_their_patch_and_are_located():
    scene = scene_of((rectangle((0, 0, 0), (4, 0, 0), (0, 2, 0)), BLACK), (rectangle((0, 0, 1), (1, 0, 0), (0, 1, 0)),
                                                                         BLACK))
    refined = refine(scene, max_edge=1.0, finer=lambda cuts: {0: KNOTS[1]})
    assert refined.cuts.counts.tolist() == [[2, 3], [1, 1]]
    assert refined.first.tolist() == [0, 6]
    np.testing.assert_allclose(refined.scene.areas[:6], np.outer([0.25, 0.25, 0.5], [0.1, 0.9]).ravel() * 8)
    centres = refined.scene.centres[:6]
    found = refined.locate(np.zeros(6, dtype=int), centres[:, 0] / 4, centres[:, 1] / 2)
    assert found.tolist() == list(range(6))


def element_at(refined, knots, patch, u, v):
    """The element at a point of a patch, by a search for its strip among the knots of patch 0, or by division."""
    columns, rows = refined.cuts.counts[patch]
    u = u * (1 - v) if refined.is_triangle[patch] else u
    along, up = (np.interp(place, knots[axis], range(len(knots[axis]))) if patch == 0 else place * count
                 for axis, (place, count) in enumerate(((u, columns), (v, rows))))
    row = min(int(up), rows - 1)
    if not refined.is_triangle[patch]:
        return refined.first[patch] + row * columns + min(int(along), columns - 1)
    column = min(int(along), columns - 1 - row)
    # Of n x n elements row r has 2 (n - r) - 1, upright and inverted ones by turns.
    inverted = (along - column) + (up - row) > 1 and column < columns - 1 - row
    return refined.first[patch] + sum(2 * (columns - k) - 1 for k in range(row)) + 2 * column + inverted


def test_points_lie_in_the_elements_that_a_search_finds():
    triangle = np.array([(0, 0, 2), (3, 0, 2), (1, 2, 2), (1, 2, 2)], dtype=float)
    scene = scene_of((rectangle((0, 0, 0), (4, 0, 0), (0, 2, 0)), BLACK), (triangle, BLACK),
                     (rectangle((0, 0, 1), (1, 0, 0), (0, 1, 0)), BLACK))
    refined = refine(scene, max_edge=0.6, finer=lambda cuts: {0: KNOTS[2]})
    random = np.random.default_rng(3)
    patch, u, v = random.integers(3, size=3000), *random.choice([0, 0.5, 0.6, 1, *random.random(40)], (2, 3000))
    found = refined.locate(patch, u, v)
    assert len(np.unique(found)) > 30
    assert found.tolist() == [element_at(refined, KNOTS[2], *point) for point in zip(patch, u, v, strict=True)]
