"""View factors of groups of patches: closed forms of what was cut, and errors by hand."""


import numpy as np
import pytest
from scipy import sparse

from benchmarks.closed_forms import c_11
from golden.cast.grid import Grid
from golden.light.factors.compute import compute_view_factors
from golden.light.factors.groups import by_surface, grouped
from golden.light.factors.rows import FactorRows
from golden.scene.material import Material
from golden.scene.refine import refine
from tb.golden.light.factors.samples import three_sides
from tb.golden.light.scenes import rectangle, scene_of


def test_squares_that_are_cut_see_each_other_as_whole_ones():
    """Opposed unit squares at distance 1, of whose parts no two are alike, and the whole ones' closed form."""
    scene = scene_of(([rectangle((0, 0, 0), (0.3, 0, 0), (0, 1, 0)), rectangle((0.3, 0, 0), (0.7, 0, 0), (0, 1, 0))],
                      Material(name="lower")),
                     ([rectangle((0, 0, 1), (0, 1, 0), (1, 0, 0))], Material(name="a lid")))
    cut = refine(scene, max_edge=0.75).scene
    found = by_surface(compute_view_factors(FactorRows(cut, Grid(cut), error=1e-2)))
    assert found.surface.tolist() == ["a lid", "lower"]
    expected = c_11(1, 1)
    np.testing.assert_allclose(found.F.toarray(), [[0, expected], [expected, 0]], atol=1e-9)
    np.testing.assert_allclose(found.area, 1)
    np.testing.assert_allclose(found.sky, 1 - expected, atol=1e-9)
    np.testing.assert_allclose(found.normal, [(0, 0, -1), (0, 0, 1)], atol=1e-12)
    assert found.closure < 1e-9
    assert found.reciprocity < 1e-9


def test_means_and_errors_of_a_group_are_those_by_hand():
    """Sides of 3 and 5 are one: A F from 0 to 2 is 1.8, so F[a, a] = 2 x 1.8 / 8, of one estimate; its error doubles.

    From the side of 4 to both: errors of independent pairs add up by squares.
    """
    factors = three_sides(front=np.ones(3, dtype=bool), patch=np.arange(3))
    found = grouped(factors, np.array([0, 1, 0]))
    F = np.array([[(3 * 0.6 + 5 * 0.4) / 8, (3 * 0.3 + 5 * 0.6) / 8], [1, 0]])
    np.testing.assert_allclose(found.F.toarray(), F)
    np.testing.assert_allclose(found.unprojected.toarray(), 1.01 * F)
    error = factors.error.toarray()
    within = np.sqrt(2 * ((3 * error[0, 2])**2 + (5 * error[2, 0])**2)) / 8
    np.testing.assert_allclose(found.error.toarray(), [
        [within, np.hypot(3 * error[0, 1], 5 * error[2, 1]) / 8], [np.hypot(error[1, 0], error[1, 2]), 0]])
    np.testing.assert_allclose(found.sky, [3 * 0.06 / 8, 0])
    np.testing.assert_allclose(found.back, [3 * 0.04 / 8, 0])
    np.testing.assert_allclose(found.unprojected_sky, [3 * 0.08 / 8, 0])
    np.testing.assert_allclose(found.sky_error, [3 * 0.01 / 8, 0.004])
    np.testing.assert_allclose(found.sky_patches.toarray(), [(0, 0.015, 0, 0.0075), (0,) * 4])
    np.testing.assert_allclose(found.sky_patches_error.toarray(), [(0, 0.009 / 8, 0, 0.003 / 8), (0,) * 4])
    # The side of 4 may have missed a factor to either of the others.
    assert found.hidden_error == pytest.approx(0.001 * np.sqrt(2))
    assert (found.surface.tolist(), found.patch.tolist()) == (["sun", "Wand süd"], [0, 1])
    assert found.row_sums is None


def test_groups_of_one_change_nothing():
    factors = three_sides(row_sums=None, weight_bits=None)
    found = grouped(factors, np.arange(3))
    for name, value in vars(factors).items():
        other = getattr(found, name)
        if sparse.issparse(value):
            np.testing.assert_allclose(other.toarray(), value.toarray(), atol=1e-15)
        elif name not in ("settings", "row_sums", "weight_bits", "surface", "patch"):
            np.testing.assert_allclose(other, value, atol=1e-15)


def test_backs_are_surfaces_of_their_own():
    scene = scene_of(([rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0))], Material(name="lower"), {"two_sided": True}),
                     ([rectangle((0, 0, 1), (0, 1, 0), (1, 0, 0))], Material(name="lid")))
    found = by_surface(compute_view_factors(FactorRows(scene, Grid(scene), error=1e-2)))
    assert found.surface.tolist() == ["lid", "lower", "lower (back)"]
    np.testing.assert_allclose(found.sky[2], 1)
