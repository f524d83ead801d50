"""View factors from points: closed forms, with and without what hides, in at least the stated certainty."""

import csv

import numpy as np
import pytest

from benchmarks.closed_forms import b_4
from golden.cast.grid import Grid
from golden.light.factors.csv_file import write_receivers
from golden.light.factors.receivers import receiver_factors
from golden.light.photometry.sensors import Sensors
from golden.scene.material import Material
from tb.golden.light.scenes import rectangle, scene_of

LID = [rectangle((0, 0, 1), (0, 1, 0), (1, 0, 0))], Material(name="lid")
CORNER = b_4(1, 1)


def factors(scene, *points, error=2e-3, seed=0):
    position, normal = np.array(points, dtype=float).reshape(-1, 2, 3).transpose(1, 0, 2)
    return receiver_factors(scene, Grid(scene), Sensors(position=position, normal=normal), error=error, seed=seed)


def plate(low, high):
    """One halfway up that hides the part of the lid between x = 2 ``low`` and 2 ``high`` from the origin."""
    return ([rectangle((low, 0, 0.5), (0, 0.5, 0), (high - low, 0, 0))], Material(name="plate"))


@pytest.mark.parametrize(("part", "seen"), [(None, CORNER), ((0, 0.5), 0), ((0, 0.25), CORNER - b_4(0.5, 1))])
def test_a_corner_above_a_point_is_seen_as_far_as_nothing_hides_it(part, seen):
    """From the origin: the whole square, none of it, or the half that a plate leaves; twenty seeds."""
    scene = scene_of(LID, *([plate(*part)] if part else []))
    found = [factors(scene, (0, 0, 0), (0, 0, 1), seed=seed) for seed in range(20)]
    off = np.array([(one.share[0, 0] - seen) / one.error[0, 0] for one in found])
    assert np.mean(np.abs(off) <= 2) >= 0.9
    assert max(2 * one.error.max() for one in found) <= 2e-3
    for one in found:
        assert one.names == ["lid", *["plate"] * bool(part)]
        assert one.share.sum() == pytest.approx(1, abs=1e-12)


def test_a_smaller_error_takes_more_rays():
    coarse, fine = (factors(scene_of(LID), (0.1, 0.2, 0), (0, 0, 1), error=error) for error in (1e-2, 3e-4))
    assert 2 * fine.error.max() == 3e-4 < 2 * coarse.error.max() <= 1e-2


def test_what_no_ray_meets_has_the_bound_of_all_rays():
    """Half of Wilson's interval, though the search for the lid's error ends at the requested one."""
    found = factors(scene_of(LID), (0.1, 0.2, 0), (0, 0, 1))
    assert 2 * found.error[0, 0] == 2e-3
    assert found.error[0, 2] == pytest.approx(2 / (4 * 4096 + 4))


def test_backs_and_sides_are_targets_of_their_own():
    """Above a two-sided plate its back is a surface; beyond the plane of a one-sided lid its back is black."""
    scene = scene_of(LID, ([rectangle((5, 0, 0), (1, 0, 0), (0, 1, 0))], Material(name="plate"), {"two_sided": True}))
    found = factors(scene, (0.5, 0.5, 2), (0, 0, -1), (5.5, 0.5, -1), (0, 0, 1), (0.5, 0.5, 1), (0, 0, 1))
    assert found.names == ["lid", "plate", "plate (back)"]
    middle = 4 * b_4(0.5, 0.5)
    share = found.share
    assert share[0, 4] == pytest.approx(middle, abs=3 * found.error[0, 4])
    assert share[1, 2] == pytest.approx(middle, abs=3 * found.error[1, 2])
    # A point on the lid is not hidden by it.
    assert share[2, 3] == 1
    np.testing.assert_allclose(share.sum(axis=1), 1)


def test_many_points_are_cast_in_blocks_with_the_same_result(monkeypatch):
    points = [((x, 0.5, 0), (0, 0, 1)) for x in np.linspace(0.1, 0.9, 5)]
    whole = factors(scene_of(LID), *points)
    monkeypatch.setattr("golden.light.factors.receivers._RAYS", 1)
    single = factors(scene_of(LID), *points)
    np.testing.assert_array_equal(single.share, whole.share)
    # Points at equal distances from the middle see as much.
    np.testing.assert_allclose(whole.share[:, 0], whole.share[::-1, 0], atol=4e-3)


def test_a_table_has_a_line_for_each_target_that_a_point_sees(tmp_path):
    found = factors(scene_of(LID), (0, 0, 0), (0, 0, 1), (0, 0, 2), (0, 0, 1))
    write_receivers(found, tmp_path / "a.csv")
    with (tmp_path / "a.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["receiver"], row["to"]) for row in rows] == [("0", "lid"), ("0", "(sky)"), ("1", "(sky)")]
    assert float(rows[0]["view_factor"]) == found.share[0, 0]
    assert float(rows[0]["standard_error"]) == found.error[0, 0]
    assert float(rows[2]["view_factor"]) == 1
