import numpy as np
import pytest

from benchmarks.closed_forms import c_11
from benchmarks.view_factor_cases import visible_factor
from golden.cast.grid import Grid
from golden.light.factors import visibility
from golden.light.factors.draws import segments_by_direction
from golden.light.factors.pair_factors import exchange_areas
from golden.light.factors.sides import Sides
from golden.light.factors.visibility import visible_shares
from tb.golden.light.factors.plates import plates
from tb.golden.light.scenes import BLACK, rectangle, scene_of


class CountingGrid(Grid):
    """Counts the segments that it casts."""

    segments = 0

    def occluded(self, origin, *others):
        """See `Grid`."""
        self.segments += len(origin)
        return super().occluded(origin, *others)


def shares(scene, first, second, *, limit, seed=0):
    """Factors without occlusion, the visible shares of pairs, their errors, and the segments of all."""
    sides, grid = Sides(scene), CountingGrid(scene)
    first, second = np.atleast_1d(first), np.atleast_1d(second)
    factor = exchange_areas(sides.vertices[first], sides.vertices[second]) / sides.area[first]
    return factor, *visible_shares(sides, grid, first, second, factor, limit=limit, seed=seed), grid.segments


def test_a_plate_that_covers_a_part():
    truth = visible_factor() / c_11(1, 1)
    for seed in range(3):
        factor, share, error, segments = shares(plates(), 0, 1, limit=2e-3, seed=seed)
        # That which ended the search may be too small: it counts as what was requested.
        assert factor[0] * error[0] == pytest.approx(2e-3, rel=1e-12)
        assert factor[0] * error[0] <= 2e-3
        assert share[0] == pytest.approx(truth, rel=0, abs=3 * error[0])
        assert segments > 100


def test_geometry_decides_what_agrees():
    factor, share, error, segments = shares(plates(), [0, 2, 0], [3, 1, 3], limit=1e-4)
    np.testing.assert_array_equal(share, 1)
    np.testing.assert_array_equal(error, 0)
    assert segments <= 3 * 32
    np.testing.assert_allclose(factor[:2] * [1, 0.5], factor[[2, 1]] * [1, 0.5], atol=1e-12)


def test_segments_that_agree_have_wilsons_error():
    # Two plates hide the ceiling together, which geometry does not find.
    halves = [rectangle((-1 + 1.5 * k, -1, 0.5), (1.5, 0, 0), (0, 3, 0)) for k in range(2)]
    scene = scene_of(([rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), rectangle((0, 0, 1), (0, 1, 0), (1, 0, 0)),
                       *halves], BLACK))
    factor, share, error, segments = shares(scene, 0, 1, limit=1e-3)
    assert share[0] == 0
    # Nothing scatters: no estimate that is too small by chance ended the search, so the error is not the limit.
    assert 0 < factor[0] * error[0] < 0.99e-3
    # The error of n equal segments is 2 / (n + 4), and 95 of 100 are surely alike only if the other share is below
    # twice that.
    assert segments >= 2 * factor[0] / 1e-3 - 4


def test_pairs_that_touch_behind_a_screen():
    # The screen stands across the corner between floor and wall and hides the left half of each from the other's
    # right half.
    floor, wall = rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), rectangle((0, 0, 0), (0, 1, 0), (0, 0, 1))
    screen = rectangle((0, 0.5, 0), (1, 0, 0), (0, 0, 1))
    scene = scene_of(([floor, wall], BLACK), ([screen], BLACK, {"two_sided": True}))
    factor, share, error, _ = shares(scene, 0, 1, limit=2e-3)
    half = exchange_areas(np.array([rectangle((0, 0, 0), (1, 0, 0), (0, 0.5, 0))]),
                          np.array([rectangle((0, 0, 0), (0, 0.5, 0), (0, 0, 1))]))[0]
    assert factor[0] * share[0] == pytest.approx(2 * half, rel=0, abs=8e-3)
    assert factor[0] * error[0] <= 2e-3


def test_a_pair_does_not_depend_on_the_others():
    scene = plates()
    _, share, error, _ = shares(scene, [0, 1], [1, 0], limit=5e-3)
    _, alone, its_error, _ = shares(scene, 1, 0, limit=5e-3)
    assert share[1] == alone[0]
    assert error[1] == its_error[0]
    assert share[0] != share[1]


@pytest.mark.parametrize(("second", "by_directions"), [
    (rectangle((0, 0, 1), (0, 1, 0), (1, 0, 0)), False), (rectangle((0, 0, 0.1), (0, 1, 0), (1, 0, 0)), True),
    (rectangle((0, 0, 0), (0, 1, 0), (0, 0, 1)), True), (rectangle((0, 0, 0.1), (0, 1, 0), (0, 0, 1)), True)])
def test_near_pairs_of_an_uneven_kernel_are_joined_by_directions(second, by_directions, monkeypatch):
    drawn = []
    monkeypatch.setattr(visibility, "segments_by_direction", lambda sides, first, *others: drawn.append(
        len(first)) or segments_by_direction(sides, first, *others))
    shares(scene_of(([rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), second], BLACK)), 0, 1, limit=1e-2)
    assert (sum(drawn) > 0) == by_directions


def test_what_geometry_decides_belongs_to_its_pair():
    def between(x, plates):
        return [rectangle((x, 0, 0), (1, 0, 0), (0, 1, 0)), rectangle((x, 0, 1), (0, 1, 0), (1, 0, 0)), *plates]

    halves = [rectangle((-1 + 1.5 * k, -1, 0.5), (1.5, 0, 0), (0, 3, 0)) for k in range(2)]
    whole = rectangle((9, -1, 0.5), (3, 0, 0), (0, 3, 0))
    scene = scene_of(([*between(0, halves), *between(10, [whole])], BLACK))
    _, share, error, _ = shares(scene, [0, 4], [1, 5], limit=1e-3)
    assert (error == 0).tolist() == [False, True]
    assert share.tolist() == [0, 0]
