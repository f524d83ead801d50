"""What is known of the cases' view factors, by other means."""

import numpy as np
import pytest
from scipy import sparse

from benchmarks.analytic import polygon_to_polygon
from benchmarks.view_factor_cases import HIDDEN, OPEN, Case, box_in_box, visible_factor
from golden.scene.scene import Scene
from tb.golden.light.factors.samples import three_sides

CASES = {case.name: case for case in (make() for make in (*OPEN, *HIDDEN))}


@pytest.mark.parametrize("name", CASES)
def test_shares_are_reciprocal(name):
    case = CASES[name]
    area = Scene.from_arrays(case.facets).areas
    assert case.known
    shares = {(tuple(starts), tuple(ends)): share * area[starts].sum() for starts, ends, share in case.known
              if ends is not None}
    for (starts, ends), exchange in shares.items():
        assert 0 < exchange <= area[list(starts)].sum()
        assert shares.get((ends, starts), exchange) == pytest.approx(exchange, rel=1e-9)


@pytest.mark.parametrize("name", [case.name for case in (make() for make in OPEN) if len(case.facets) < 9])
def test_shares_without_occlusion_are_integrals(name):
    case = CASES[name]
    area = Scene.from_arrays(case.facets).areas
    for starts, ends, share in case.known:
        others = [k for k in range(len(case.facets)) if k not in starts] if ends is None else ends
        seen = sum(area[i] * polygon_to_polygon(case.facets[i], case.facets[j]) for i in starts for j in others)
        seen /= area[starts].sum()
        assert (1 - seen if ends is None else seen) == pytest.approx(share, abs=1e-6)


def test_the_barrier_of_a_canyon_hides_the_foot_of_the_wall():
    case, = (case for name, case in CASES.items() if "barrier" in name)
    x = (np.arange(4000) + 0.5) / 8000
    foot = 0.25 * (1 - x) / (0.5 - x)
    sine = [(1 - x) / np.hypot(1 - x, height) for height in (np.minimum(foot, 1), 1)]
    assert case.known[0][2] == pytest.approx(np.mean(sine[0] - sine[1]) / 2, abs=1e-6)


def test_a_wide_plate_hides_all():
    assert visible_factor(1.0) == pytest.approx(0, abs=1e-9)


def test_cut_faces_fill_the_whole_ones():
    whole, cut = (Scene.from_arrays(box_in_box(0.5, cuts).facets) for cuts in (1, 3))
    assert len(cut) == 9 * len(whole)
    np.testing.assert_allclose(cut.areas.reshape(12, 9).sum(axis=1), whole.areas)
    np.testing.assert_allclose(cut.normals.reshape(12, 9, 3), whole.normals[:, None].repeat(9, axis=1), atol=1e-12)
    np.testing.assert_allclose(cut.centres.reshape(12, 9, 3).mean(axis=1), whole.centres)


def test_the_largest_difference_counts():
    case = Case(name="two", facets=np.zeros((2, 4, 3)),
                known=[([0], [1], 0.5), ([0, 1], [0, 1], 0.4), ([1], None, 0.2)])
    F, area = np.array([[0, 0.5], [0.25, 0]]), np.array([1.0, 3.0])
    assert case.largest_error(F, np.array([0.1, 0.25]), area) == pytest.approx(0.0875)
    assert case.largest_error(np.array([[0, 0.4], [0.4, 0]]), None, area) == pytest.approx(0.1)


def test_deviations_are_those_of_single_pairs_that_are_not_exact():
    matrix = sparse.csr_array(np.array([[0, 0.3, 0.3], [0.3, 0, 0.1], [0.3, 0.1, 0]]))
    error = sparse.csr_array((np.array([0.03, 0.04, 0.03, 0, 0.04, 0]), matrix.indices, matrix.indptr), shape=(3, 3))
    found = three_sides(F=matrix, unprojected=matrix, error=error, area=np.ones(3))
    case = Case(name="three", facets=np.zeros((3, 4, 3)), known=[
        ([0], [1, 2], 0.5), ([0], [1], 0.36), ([1], [0], 0.36), ([1], [2], 0.2), ([2], [0], 0.2), ([1], None, 0.1)])
    np.testing.assert_allclose(case.deviations(found), [-2, 2.5])
