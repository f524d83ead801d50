import tracemalloc
from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.analytic import point_to_polygon
from benchmarks.closed_forms import b_4, c_11, c_14, c_41
from golden.base.errors import InputError
from golden.base.spread import in_turn
from golden.cast.frame import frame
from golden.cast.grid import Grid
from golden.cast.hemisphere import Hemisphere
from golden.cast.naive import Naive
from golden.light import form_factors
from golden.light.form_factors import PatchRows, gauss_points, hemisphere_sums, patch_columns
from golden.light.glass import ClearRays, Glass
from golden.scene.builder import SceneBuilder
from golden.scene.builtin import builtin_scene
from golden.scene.material import Material
from tb.golden.hostile_spread import HostileSpread
from tb.golden.light.cube import cube
from tb.golden.light.hemisphere_factors import hemisphere_factors
from tb.golden.light.scenes import BLACK, rectangle, scene_of
from tb.lib.schedules import SETTINGS

PLATE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
RAYS = (1024, 256)


def build(*patches, **properties):
    builder = SceneBuilder("test")
    builder.add(np.array(patches), Material(name="grey"), **properties)
    return builder.build()


def lifted(polygon, z):
    """The polygon at height z, its front down."""
    return polygon[::-1] + np.array((0, 0, z))


def disc(sides):
    """Quadrilaterals of a regular polygon of area pi, front up; every second vertex is one of theirs alone."""
    angle = 2 * np.pi * np.arange(sides + 1) / sides
    radius = np.sqrt(2 * np.pi / sides / np.sin(2 * np.pi / sides))
    border = radius * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    border[-1] = border[0]
    return np.stack([np.zeros((sides // 2, 3)), border[:-2:2], border[1:-1:2], border[2::2]], axis=1)


@pytest.mark.parametrize(("scene", "truth"), [
    (build(PLATE, lifted(PLATE, 1)), c_11(1, 1)),
    (build(PLATE, PLATE[:, [2, 0, 1]]), c_14(1, 1)),
], ids=["C-11", "C-14"])
def test_casting_meets_the_catalogue_at_nine_gauss_points(scene, truth):
    factors, *_ = PatchRows(scene, Grid(scene), rays=RAYS, samples=3).cast([0])
    assert factors[0, 1] == pytest.approx(truth, rel=0, abs=5e-4)


def test_casting_meets_b4_at_one_point():
    scene = build(lifted(PLATE, 1))
    sums = hemisphere_sums(Naive(scene), Hemisphere(*RAYS), [(0, 0, 0)], [(0, 0, 1)], -1, columns=1,
                           column_of=patch_columns(scene))
    assert sums.row_sums[0] / 2**32 == pytest.approx(b_4(1, 1), rel=0, abs=5e-4)


def test_casting_meets_c41_at_eight_rings_of_equal_area():
    scene = build(*(lifted(patch, 1) for patch in disc(128)))
    points = np.zeros((8, 3))
    points[:, 0] = np.sqrt((np.arange(8) + 0.5) / 8)
    sums = hemisphere_sums(Grid(scene), Hemisphere(*RAYS), points, np.tile((0.0, 0, 1), (8, 1)), -1, columns=len(scene),
                           column_of=patch_columns(scene))
    assert (sums.row_sums / 2**32).mean() == pytest.approx(c_41(1, 1), rel=0, abs=5e-4)


def test_casting_meets_the_analytic_form_factors_of_every_pair():
    scene = cube(3)
    points, _ = gauss_points(scene, 1)
    exact = point_to_polygon(points[:, 0], scene.normals, scene.vertices)
    some = [0, 13, 43]
    cast = PatchRows(scene, Grid(scene), rays=RAYS).rows(some)
    assert np.abs(cast.toarray() - exact[some]).max() < 5e-4


@pytest.mark.parametrize("scene", [cube(5), builtin_scene("furnace:4")], ids=["cube5", "furnace4"])
@pytest.mark.parametrize("rays", [(64, 16), (2048, 8)])
def test_a_hemisphere_in_a_closed_scene_sums_to_one_exactly(scene, rays):
    some = np.unique(np.linspace(0, len(scene) - 1, 12).astype(int))
    factors, row_sums, _ = PatchRows(scene, Grid(scene), rays=rays, samples=2).cast(some)
    assert row_sums.dtype == np.int64
    assert row_sums.shape == (len(some), 4)
    assert (row_sums == 2**Hemisphere(*rays).weight_bits).all()
    np.testing.assert_allclose(factors.sum(axis=1), 1, rtol=0, atol=1e-14)


def test_a_turned_and_stretched_closed_scene_loses_no_ray():
    generator = np.random.default_rng(11)
    scene = cube(4)
    turn = np.linalg.qr(generator.normal(size=(3, 3)))[0] * (1.0, 0.37, 11.0)
    turn *= np.sign(np.linalg.det(turn))
    turned = build(*(scene.vertices @ turn), surface=scene.surface)
    result = hemisphere_factors(turned, Grid(turned), rays=(64, 16))
    assert (result.row_sums == 2**32).all()


def test_patches_see_nothing_of_their_own_surface():
    scene = cube(3)
    factors = hemisphere_factors(scene, Grid(scene), rays=(64, 16)).F.toarray()
    assert (factors[scene.surface[:, None] == scene.surface] == 0).all()


def test_a_patch_between_hides():
    scene = build(PLATE, lifted(PLATE, 1), PLATE * 20 + np.array((-10, -10, 0.5)))
    factors = hemisphere_factors(scene, Naive(scene), rays=(64, 16), samples=2).F.toarray()
    assert factors[0, 1] == factors[1, 0] == 0
    assert factors[1, 2] > 0.9


def test_backs_of_one_sided_patches_block_but_take_no_light():
    plates = (PLATE, lifted(PLATE, 1)[::-1])
    for two_sided in (False, True):
        scene = build(*plates, two_sided=two_sided)
        result = hemisphere_factors(scene, Naive(scene), rays=(64, 16))
        assert (result.F[0, 1] > 0.2) == two_sided
        assert result.row_sums[0, 0] > 0.2 * 2**32
        assert result.row_sums[1, 0] == 0


def test_callers_may_count_by_their_own_columns():
    scene = cube(1)

    def half_of_the_hit_patch(direction, hits):
        assert direction.shape == (len(hits.patch), 3)
        return np.where(hits.u < 0.5, 2 * hits.patch, 2 * hits.patch + 1)

    points, normals = scene.vertices.mean(axis=1), scene.normals
    arguments = Grid(scene), Hemisphere(64, 16), points, normals, scene.surface
    whole = hemisphere_sums(*arguments, columns=6, column_of=patch_columns(scene))
    halves = hemisphere_sums(*arguments, columns=12, column_of=half_of_the_hit_patch)
    pairs = halves.weights.toarray().reshape(6, 6, 2)
    assert (pairs.sum(axis=2) == whole.weights.toarray()).all()
    assert (pairs[0, 1] > 0).all()


@pytest.mark.parametrize("glass", [False, True])
def test_results_depend_neither_on_blocks_nor_on_the_order_in_which_they_end(glass, monkeypatch):
    """Of hemispheres half of which see the sky, some of them through a pane."""
    roof = lifted(PLATE, 0.1)
    pane = Material(name="pane", transparent=(0.5, 0.5, 0.5)) if glass else Material(name="grey")
    scene = scene_of((PLATE, Material(name="floor")), (roof, pane))
    points = np.array([(x, 0.5, z) for z in (0, 0.2) for x in (0.1, 0.4, 0.6, 0.9)])
    clear = ClearRays(scene, Glass(scene), Naive(scene), 0) if glass else None
    found = []
    # 32 rays each: all hemispheres in one block, blocks of one hemisphere, and parts of one.
    for block, spread in ((1 << 18, in_turn), (40, HostileSpread()), (7, HostileSpread(1))):
        monkeypatch.setattr(form_factors, "_BLOCK", block)
        found.append(hemisphere_sums(Naive(scene), Hemisphere(8, 4), points, np.tile((0.0, 0, 1), (8, 1)), -1,
                                     columns=2, column_of=patch_columns(scene), clear=clear, spread=spread,
                                     sky=lambda direction: direction + 1))
    assert (found[0].light[4:] > found[0].light[:4]).all()
    for other in found[1:]:
        np.testing.assert_allclose(other.light, found[0].light, rtol=1e-14)
        np.testing.assert_array_equal(other.row_sums, found[0].row_sums)
        np.testing.assert_array_equal(other.weights.toarray(), found[0].weights.toarray())


@settings(SETTINGS, max_examples=40)
@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 2), st.integers(-1, 4)), max_size=12))
def test_entries_are_summed_by_owner_and_column(entries):
    """Entries of owner, weight and column; owners may have none, and weights may be zero."""
    owner, weight, column = np.array(np.array(sorted(entries), dtype=np.int64).reshape(-1, 3).T)
    sums = Counter()
    for row, value, met in zip(owner.tolist(), weight.tolist(), column.tolist(), strict=True):
        sums[row, met] += value if met >= 0 else 0
    expected = [(value, row, met) for (row, met), value in sorted(sums.items()) if value]
    rows = list(zip(*(part.tolist() for part in form_factors._entries(owner, weight, column, 5)), strict=True))
    assert sorted(rows, key=lambda one: one[1:]) == expected
    assert [row for _, row, _ in rows] == sorted(row for _, row, _ in rows)


def test_rows_on_demand_are_rows_of_the_whole():
    scene = cube(2)
    rows = PatchRows(scene, Grid(scene), rays=(32, 8), samples=2)
    whole = hemisphere_factors(scene, Grid(scene), rays=(32, 8), samples=2).F.toarray()
    np.testing.assert_array_equal(rows.rows([7, 3]).toarray(), whole[[7, 3]])


def test_no_points_give_an_empty_matrix():
    scene = cube(1)
    sums = hemisphere_sums(Naive(scene), Hemisphere(4, 4), np.empty((0, 3)), np.empty((0, 3)), -1, columns=6,
                           column_of=patch_columns(scene))
    assert sums.weights.shape == (0, 6)
    assert sums.row_sums.shape == (0,)


TRIANGLE = np.array([(0, 0, 0), (3, 0, 1), (1, 2, 0), (1, 2, 0)], dtype=float)
TRAPEZOID = np.array([(0, 0, 0), (4, 0, 0), (2.5, 2, 0), (2, 2, 0)], dtype=float)


@pytest.mark.parametrize("order", range(1, 8))
def test_gauss_points_share_out_the_area(order):
    scene = build(TRIANGLE, TRAPEZOID, PLATE)
    points, shares = gauss_points(scene, order)
    assert points.shape == (3, order**2, 3)
    assert shares.min() > 0
    np.testing.assert_allclose(shares.sum(axis=1), 1, rtol=0, atol=1e-15)


@pytest.mark.parametrize(("patch", "order"), [(TRIANGLE, 1), (TRIANGLE, 3), (PLATE, 1), (TRAPEZOID, 2), (TRAPEZOID, 5)])
def test_gauss_points_have_the_patch_centroid(patch, order):
    points, shares = gauss_points(build(patch), order)
    halves = patch[[[0, 1, 2], [0, 2, 3]]]
    areas = np.linalg.norm(np.cross(halves[:, 1] - halves[:, 0], halves[:, 2] - halves[:, 0]), axis=1)
    np.testing.assert_allclose(shares[0] @ points[0], areas @ halves.mean(axis=1) / areas.sum(), atol=1e-14)


@pytest.mark.parametrize("degree", [2, 3, 4])
def test_gauss_points_integrate_powers_over_a_triangle(degree):
    points, shares = gauss_points(build(np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 1, 0)], dtype=float)), 3)
    # The mean of x^k over the unit triangle is 2 / ((k + 1)(k + 2)).
    assert shares[0] @ points[0, :, 0]**degree == pytest.approx(2 / ((degree + 1) * (degree + 2)), rel=1e-13)


@pytest.mark.parametrize(("arguments", "message"), [
    ({"rays": (1000, 256)}, "Azimuths must be a power of two"),
    ({"rays": (64, 16), "samples": 0}, "Samples must be 1 to 16"),
    ({"rays": (64, 16), "samples": 17}, "Samples must be 1 to 16"),
    ({"rays": (64, 16), "samples": 1.5}, "Samples must be 1 to 16"),
])
def test_unusable_grids_are_refused(arguments, message):
    scene = cube(1)
    with pytest.raises(InputError, match=message):
        hemisphere_factors(scene, Naive(scene), **arguments)


@pytest.mark.parametrize("glazed", [False, True])
def test_the_sky_is_summed_over_the_rays_that_meet_nothing(glazed):
    """By its radiance in their directions, behind glass too: here the cosine, whose mean over a sky is 2/3."""
    pane = Material(name="pane", transparent=(1, 1, 1), refraction_index=1.0)
    lid = rectangle((-99, -99, 1), (198, 0, 0), (0, 198, 0))
    scene = scene_of((lid, pane if glazed else BLACK))
    clear = ClearRays(scene, Glass(scene), Grid(scene), 0) if glazed else None
    sums = hemisphere_sums(Grid(scene), Hemisphere(64, 16), [(0, 0, 2), (0, 0, 0)], [(0, 0, 1), (0, 0, 1)], -1,
                           columns=1, column_of=patch_columns(scene), clear=clear,
                           sky=lambda direction: direction[:, 2:] * (1, 2, 3))
    assert sums.light[0] / 2**sums.weight_bits == pytest.approx(np.array((1, 2, 3)) * 2 / 3, rel=0.02)
    below = np.array((1, 2, 3)) * 2 / 3 if glazed else np.zeros(3)
    assert sums.light[1] / 2**sums.weight_bits == pytest.approx(below, rel=0.02)


def test_directions_are_turned_into_each_frame():
    frames = frame(np.array([(0, 0, 1.0), (0.6, 0, 0.8), (0, -0.8, -0.6)]))
    hemisphere, points, surfaces = Hemisphere(16, 4), np.arange(9.0).reshape(3, 3), np.array([4, -1, 2])
    sample, ray = np.repeat([0, 2, 1], 64), np.tile(np.arange(64), 3)
    rays = form_factors._hemisphere_rays(hemisphere, points, frames, surfaces, sample, ray)
    expected = np.einsum("rk,rki->ri", hemisphere.directions[ray], frames[sample])
    assert rays.direction == pytest.approx(expected, rel=1e-14)
    assert (rays.origin[70].tolist(), rays.source[70]) == ([6, 7, 8], 2)


def test_rows_take_little_memory_beside_their_entries(monkeypatch):
    """An entry has 12 bytes; blocks of rays are small here. While weights are joined they are there twice."""
    monkeypatch.setattr(form_factors, "_BLOCK", 1 << 12)
    hemisphere, count = Hemisphere(64, 16), 512
    scene, centre = cube(1), np.full((count, 3), 0.5)

    def sums(count):
        return hemisphere_sums(Naive(scene), hemisphere, centre[:count], np.tile((0.0, 0, 1), (count, 1)), -1,
                               columns=len(hemisphere),
                               column_of=lambda direction, hits: np.arange(len(hits.patch)) % len(hemisphere))

    sums(4)
    tracemalloc.start()
    try:
        found = sums(count)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert found.weights.nnz == count * len(hemisphere)
    assert peak < (12 + 8) * found.weights.nnz + 1000 * (1 << 12)
