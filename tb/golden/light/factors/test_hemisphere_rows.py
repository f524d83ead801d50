import numpy as np
import pytest

from golden.cast.grid import Grid
from golden.light.factors.compute import compute_view_factors
from golden.light.factors.hemisphere_rows import HemisphereRows
from tb.golden.light.cube import cube
from tb.golden.light.scenes import BLACK, rectangle, scene_of


def view_factors(scene, **settings):
    return compute_view_factors(HemisphereRows(scene, Grid(scene), rays=(32, 8), **settings))


def test_a_projected_cube_is_closed_and_reciprocal():
    plain, projected = (view_factors(cube(2), projected=given) for given in (False, True))
    assert plain.unprojected is None
    assert plain.reciprocity > 0.01
    assert projected.closure <= 1e-12
    assert projected.reciprocity <= 1e-15
    assert projected.error is None
    np.testing.assert_array_equal(projected.unprojected.toarray(), plain.F.toarray())
    np.testing.assert_array_equal(projected.row_sums, plain.row_sums)
    # A closed scene stays so.
    assert projected.sky.max() == projected.unprojected_sky.max() == 0
    assert projected.back.max() <= 1e-12


def test_sky_and_backs_move_within_their_errors():
    floor, lid = rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), rectangle((0, 0, 1), (0, 1, 0), (1, 0, 0))
    roof = rectangle((0, 0, 2), (2, 0, 0), (0, 1, 0))
    found = view_factors(scene_of(([floor, lid, roof], BLACK)), projected=True)
    assert found.closure <= 1e-12
    assert found.F[0, 1] == pytest.approx(found.F[1, 0])
    assert found.back[0] > 0
    assert 0 <= found.sky_change < 5 / np.sqrt(256)
    # Nothing is in front of the roof.
    assert found.sky[2] == pytest.approx(1)


def test_an_entry_of_one_direction_has_both():
    small = rectangle((0.4, 0.4, 1), (0, 0.02, 0), (0.02, 0, 0))
    scene = scene_of(([rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), small], BLACK))
    found = view_factors(scene, projected=True)
    assert found.unprojected[0, 1] == 0 < found.unprojected[1, 0]
    assert found.F[0, 1] == pytest.approx(found.F[1, 0] * 0.02**2)


def test_samples_count_by_their_shares_of_the_patch():
    """In the middle of a floor a ceiling hides more of the sky than at its rim; no ray meets a back."""
    floor, ceiling = rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), rectangle((0, 0, 1), (0, 1, 0), (1, 0, 0))
    found = view_factors(scene_of(([floor, ceiling], BLACK)), samples=3)
    assert len(np.unique(found.row_sums[0])) > 1
    assert found.closure <= 1e-12
    assert found.back.max() <= 1e-12
