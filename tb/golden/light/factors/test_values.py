"""View factors against closed forms: rows, joined and projected."""

import numpy as np
import pytest

from benchmarks.closed_forms import c_11, c_14, c_91, c_92
from benchmarks.view_factors import measured_deviations
from golden.cast.grid import Grid
from golden.light.factors.compute import compute_view_factors
from golden.light.factors.rows import FactorRows
from golden.scene.builtin import builtin_scene
from tb.golden.light.cube import cube
from tb.golden.light.scenes import BLACK, rectangle, scene_of


def view_factors(scene, **settings):
    return compute_view_factors(FactorRows(scene, Grid(scene), **settings))


@pytest.mark.parametrize(("w", "h"), [(1, 1), (0.2, 3)])
def test_plates_with_a_common_edge_c14(w, h):
    scene = scene_of(([rectangle((0, 0, 0), (w, 0, 0), (0, 1, 0)), rectangle((0, 0, 0), (0, 1, 0), (0, 0, h))], BLACK))
    result = view_factors(scene, error=1e-5)
    assert result.F[0, 1] == pytest.approx(c_14(w, h), rel=0, abs=1e-7)


def test_the_cube_is_exact_closed_and_reciprocal():
    result = view_factors(cube(1), error=1e-5)
    expected = np.full((6, 6), c_14(1, 1))
    np.fill_diagonal(expected, 0)
    for face in range(6):
        opposite = np.argmin(cube(1).normals @ cube(1).normals[face])
        expected[face, opposite] = c_11(1, 1)
    np.testing.assert_allclose(result.F.toarray(), expected, rtol=0, atol=1e-8)
    assert result.closure <= 1e-12
    assert result.reciprocity <= 1e-15
    assert result.error.data.max() == 0


UP = np.array((0, 0, 4.0))


def prisms(sides):
    """Two coaxial prisms around cylinders of radius 1 and 2 with as much area, of height 4, which see each other."""
    angle = 2 * np.pi * np.arange(sides + 1) / sides
    rim = np.pi / sides / np.sin(np.pi / sides) * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    faces = np.stack([rim[:-1], rim[1:], rim[1:] + UP, rim[:-1] + UP], axis=1)
    return scene_of((np.concatenate([faces, (faces * (2, 2, 1))[:, ::-1]]), BLACK))


def test_prisms_approach_cylinders_with_the_square_of_their_sides():
    """What is off at a small error is the polygon: extrapolated to endless sides, the factors are the cylinders'."""
    off = []
    for sides in (12, 24):
        result = view_factors(prisms(sides), error=1e-3)
        outer = result.F.toarray()[sides:]
        off.append(np.array([outer[:, :sides].sum(axis=1).mean() - c_91(2, 4),
                             outer[:, sides:].sum(axis=1).mean() - c_92(2, 4)]))
    # What 12 sides see of each other is too much by more than ten times what is left after extrapolation.
    assert off[0][1] > 4e-3
    np.testing.assert_allclose((4 * off[1] - off[0]) / 3, 0, rtol=0, atol=4e-4)


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["lobby", "room1627"])
def test_furnished_rooms_close(name):
    for seed in range(3):
        result = view_factors(builtin_scene(name), error=1e-2, seed=seed)
        assert result.closure <= 1e-9
        assert result.reciprocity <= 1e-9
        assert not len(result.infeasible)
        assert result.largest_change <= 1e-2


@pytest.mark.nightly
def test_nine_of_ten_lie_within_two_standard_errors_which_are_at_most_twice_the_deviations():
    """Factors that are known, of pairs that see a part of each other, over 20 seeds."""
    for name, off in measured_deviations(20).items():
        assert len(off) >= 40, name
        assert np.mean(np.abs(off) <= 2) >= 0.90, name
        assert np.sqrt(np.mean(off**2)) >= 0.5, name


@pytest.mark.nightly
def test_skies_lie_within_two_standard_errors():
    """Of streets of a city, against many more rays."""
    scene = builtin_scene("city:1")
    truth = view_factors(scene, error=2e-2, sky_error=2e-3, seed=99)
    for error in (5e-2, 1e-2):
        found = view_factors(scene, error=error)
        assert np.mean(np.abs(found.sky - truth.sky) <= 2 * np.hypot(found.sky_error, truth.sky_error)) >= 0.90
        assert found.largest_sky_error <= error
