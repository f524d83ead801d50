"""Shadow rays in the machine's integers: shelling is brute force, and double precision differs within bounds."""

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.grid import Grid
from golden.cast.shadow_rays import ShadowRays
from golden.engine.cast import shadow_frusta
from golden.engine.cast.fixed_frusta import NaiveFixedFrusta, ShellingFrusta
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.cast.shadow_frusta import LEAST
from golden.engine.cast.shelling import Shelling
from golden.engine.config import Config, Icu
from golden.engine.ctu import grid_rays
from golden.engine.ctu.sector import Sector
from golden.engine.frustum.shadow_record import ShadowRecord, shadow_record
from golden.engine.icu.intersection import intersect
from golden.engine.icu.inverse_distance import encode
from golden.engine.icu.patch_setup import PatchSetup
from golden.engine.icu.shadow_memory import ShadowMemory
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.builtin import builtin_scene
from golden.scene.scene import Scene
from tb.golden.engine.cast.drawn_shadows import drawn_frustum, drawn_rays
from tb.golden.engine.icu.patches import CONFIG
from tb.golden.light.cube import cube
from tb.golden.soups import soup

# Bounds of docs/exactness.md: an edge turns by less, an end moves by less times the inverse distance of its plane.
EDGE, END = 2.0**-14, 2.0**-18


def differences(scene, rays, surfaces, hits):
    """Rays that double precision answers otherwise, and those of them that no bound explains."""
    grid, far = Grid(scene, 0.125), rays.points[rays.light]
    along = rays.targets - far
    sine = np.abs(np.einsum("ki,ki->k", along, rays.normals)) / np.linalg.norm(along, axis=1)
    skip = np.stack([rays.surfaces[rays.light], surfaces], axis=1)
    exact = grid.occluded(far, rays.targets, skip)
    # In its own plane a point receives no light.
    other = np.flatnonzero(hits.cast & (hits.blocked != exact) & (sine > 1e-9))
    explained = np.zeros(len(other), dtype=bool)
    across = np.linalg.svd(along[other, None])[2][:, 1:]
    length = np.linalg.norm(along[other], axis=1)[:, None]
    side = np.ptp(scene.bounds, axis=0).max()
    for turn in np.arange(0, 2 * np.pi, np.pi / 4):
        beside = rays.targets[other] + (EDGE * length + 2.0**-21 * side) * (
            np.cos(turn) * across[:, 0] + np.sin(turn) * across[:, 1])
        for end in (-1, 0, 1):
            moved = beside + end * (END + END * side / (length * sine[other, None])) * along[other] / sine[other, None]
            explained |= grid.occluded(far[other], moved, skip[other]) == hits.blocked[other]
    return other, other[~explained]


@pytest.mark.parametrize("seed", range(8))
def test_shelling_blocks_the_rays_that_brute_force_blocks(seed):
    scene = builtin_scene(("cornell", "lobby", "room1627")[seed // 3]) if seed % 3 == 0 else None
    geometry, record, number = drawn_frustum(seed, scene, bits=3 + seed % 4)
    expected = NaiveFixed(geometry, CONFIG).blocked(record)
    for cell, by_code in ((0.125, False), (0.0625, True)):
        blocked, counts = Shelling(geometry, CONFIG, cell=cell, by_code=by_code).blocked(record)
        np.testing.assert_array_equal(blocked, expected)
        assert counts.tests > 0
    rays = np.zeros(len(record), dtype=bool)
    rays[number] = True
    assert not expected[~rays].any()
    assert expected[rays].any()


def test_directions_are_those_of_the_rays_and_between_the_corners():
    random = np.random.default_rng(1)
    slopes = np.array([[-1 << 16, (1 << 16) - 1], [0, -1], [-12345, -54321]])
    scene = soup(1, 3)
    geometry = PatchGeometry.of(scene, CONFIG.numbers)
    for bits in (1, 4, 16 // 2):
        record, number = shadow_record(geometry.coordinates, np.zeros(3, dtype=np.int64), np.eye(3), bits,
                                       slopes=slopes, end=random.integers(1, 99, 3))
        column, row = number % record.columns, number // record.columns
        directions = record.directions(column, row)
        np.testing.assert_array_equal(directions, np.column_stack([slopes, [1 << 16] * 3]))
        corners = record.corner_directions(*(np.stack([index, index], axis=1) for index in (column, row)))
        assert (corners.min(axis=(1, 2)) <= directions).all()
        assert (directions <= corners.max(axis=(1, 2))).all()
        assert np.abs(record.offset).max() <= record.spread


def test_windows_hold_the_rays_of_whole_positions(monkeypatch):
    """Without the half position beside their middles they lose rays."""
    def lost(seed):
        geometry, record, _ = drawn_frustum(seed, share=4)
        patches, directions = PatchSetup(record, CONFIG).patches(geometry), record.all_directions()
        patch, ray = np.divmod(np.arange(len(geometry) * len(record)), len(record))
        hit, _ = intersect(patches, patch, directions[ray], CONFIG)
        row, column = np.divmod(ray[hit], record.columns)
        return np.count_nonzero(~patches.window[patch[hit]].holds(column, row, record.columns))
    assert not any(map(lost, range(6)))
    monkeypatch.setattr(ShadowRecord, "spread", 0)
    assert any(map(lost, range(6)))


def test_no_ray_of_a_position_is_nearer_than_the_bound(monkeypatch):
    """It is that of the corners of the window, not of the middles beside them."""
    def exceeds(seed):
        geometry, record, _ = drawn_frustum(seed, bits=3, share=9)
        patches = PatchSetup(record, CONFIG).patches(geometry)
        which, column, row = patches.window.pairs(record.columns)
        nearness = np.einsum("ki,ki->k", patches.factor.mantissa[which], record.directions(column, row))
        nearest = encode(nearness, patches.factor.exponent[which] - 16, CONFIG.numbers)
        return (nearest > patches.bound[which]).any()
    assert not any(map(exceeds, range(4)))
    monkeypatch.setattr(ShadowRecord, "corner_directions",
                        lambda self, columns, rows: self.directions(columns[:, :, None], rows[:, None, :]))
    assert any(map(exceeds, range(4)))


def test_a_grid_ray_is_near_all_rays_of_a_position():
    """The reach to a position's middle is longer by half its width."""
    geometry, record, _ = drawn_frustum(1, bits=4)
    whole, middles = (grid_rays.screen_rays(4, (16, 16), (4, 4), (1.0, 1.0), spread) for spread in (0.5, 0))
    np.testing.assert_array_equal(whole.column_reach, middles.column_reach + (1 << grid_rays.INDEX_FRACTION - 1))
    assert (whole.row_count >= middles.row_count).all()
    unit = Shelling(geometry, CONFIG, cell=0.0625).cluster(record, Sector.whole(record)).traversal
    np.testing.assert_array_equal(unit.rays(4).row_count, whole.row_count)


@pytest.mark.parametrize("bits", [0, 3, 6, 9, 12, 14])
def test_what_is_before_the_last_share_of_a_ray_blocks_it_however_near_the_light_is_to_the_plane(bits):
    """The share of `radiosity.visible`, 2^-16 by the light's height in a cube of side 1; in the plane nothing does."""
    random, light = np.random.default_rng(bits), np.array([0.1, 0.2, 0.3])
    share, corners = 2.0 ** (bits - 16), np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    for _ in range(6):
        normal, across, other = np.linalg.qr(random.normal(size=(3, 3)))[0].T
        # A wall at right angles to the plane, and two specks that make the cube of side 4.
        for height, expected in (4 * 2.0**-bits, True), (0, False):
            target = light + across * 1.2 - normal * height
            middle = light + (1 - 1.05 * share) * (target - light)
            toward = (target - light) / np.linalg.norm(target - light)
            side = np.cross(toward, other)
            wall = middle + 0.9 * (corners[:, :1] * side + corners[:, 1:] * other)
            speck = 2 * np.array([[-1, -1, -1], [1, 1, 1]])[:, None] + 1e-3 * np.pad(corners, ((0, 0), (0, 1)))
            scene = Scene.from_arrays(np.concatenate([[wall], speck]), name="wall")
            hits = ShellingFrusta(scene).shadows(ShadowRays(
                points=light[None], surfaces=np.array([-1]), light=np.zeros(1, dtype=int), targets=target[None],
                normals=normal[None]), least=1)
            assert hits.cast.all()
            assert hits.blocked.tolist() == [expected]


def test_a_ray_is_blocked_before_its_end_alone_and_in_any_order():
    _, record, number = drawn_frustum(2)
    ends = record.end[number[:4]]
    for order in ([0, 1, 2, 3], [3, 2, 1, 0]):
        memory = ShadowMemory(record, CONFIG)
        for one in order:
            # At the end, behind it, in front of it, and both.
            hits = {0: ends[:1], 1: ends[1:2] - 1, 2: ends[2:3] + 1, 3: ends[3] + np.array([-1, 1])}[one]
            memory.update(np.full(len(hits), number[one]), hits, None)
        assert memory.blocked[number[:4]].tolist() == [False, False, True, True]
        assert not np.delete(memory.blocked, number[:4]).any()
        assert (memory.inverse[number[2:4]] == CONFIG.numbers.inverse.high).all()
    with pytest.raises(InputError, match="Rays must be at most"):
        ShadowMemory(record, Config(icu=Icu(rays=256)))


def test_what_blocks_a_ray_does_not_depend_on_the_other_rays(monkeypatch):
    scene = builtin_scene("lobby")
    rays, _ = drawn_rays(scene, 3000, 1, lights=2)
    caster = ShellingFrusta(scene)
    whole = caster.shadows(rays)
    part = np.arange(0, 3000, 2)
    half = caster.shadows(ShadowRays(points=rays.points, surfaces=rays.surfaces, light=rays.light[part],
                                     targets=rays.targets[part], normals=rays.normals[part]))
    both = half.cast & whole.cast[part]
    assert both.sum() > 1000
    np.testing.assert_array_equal(half.blocked[both], whole.blocked[part][both])
    monkeypatch.setattr(shadow_frusta, "MOST_BITS", 4)
    coarse = caster.shadows(rays)
    both = coarse.cast & whole.cast
    assert 500 < both.sum() < whole.cast.sum()
    np.testing.assert_array_equal(coarse.blocked[both], whole.blocked[both])


def test_each_ray_is_in_one_frustum_that_has_enough_rays():
    scene = builtin_scene("cornell")
    rays, _ = drawn_rays(scene, 4000, 3, lights=2)
    seen = np.zeros(len(rays), dtype=int)
    coordinates = PatchGeometry.of(scene, CONFIG.numbers).coordinates
    for rows, record, number in shadow_frusta.shadow_frusta(rays, coordinates):
        seen[rows] += 1
        assert len(rows) == len(np.unique(number)) >= LEAST
        assert len(np.unique(rays.light[rows])) == 1
        directions = record.directions(number % record.columns, number // record.columns)
        local = (rays.targets[rows] - coordinates.points(record.origin)) @ (record.matrix / 2.0**16).T
        np.testing.assert_allclose(directions / 2.0**16, local / local[:, 2:], atol=2.0**-16)
    assert seen.max() == 1
    hits = ShellingFrusta(scene).shadows(rays)
    np.testing.assert_array_equal(hits.cast, seen == 1)
    assert hits.cast.mean() > 0.7
    assert hits.tests[hits.cast].min() >= 0 == hits.tests[~hits.cast].sum()
    np.testing.assert_array_equal(NaiveFixedFrusta(scene).shadows(rays).blocked, hits.blocked)


@pytest.mark.parametrize("away", [0.3, 1, 3, 20, 100])
def test_a_frustum_from_afar_has_rays_for_the_grid_rays_before_the_scene(away):
    """As many for each as `LEAST` rays have positions."""
    scene, random = cube(4), np.random.default_rng(0)
    point = np.mean(scene.bounds, axis=0) + np.ptp(scene.bounds, axis=0).max() * np.array([0, 0, 0.5 + away])
    rays = ShadowRays(points=point[None], surfaces=np.array([-1]), light=np.zeros(4000, dtype=int),
                      targets=random.uniform(*scene.bounds, (4000, 3)), normals=np.tile([0, 0, 1.0], (4000, 1)))
    coordinates = PatchGeometry.of(scene, CONFIG.numbers, [point]).coordinates
    sizes = [len(rows) for rows, *_ in shadow_frusta.shadow_frusta(rays, coordinates)]
    assert bool(sizes) == (away < 10)
    if sizes:
        grids = [grid_rays.screen_rays(shell, (16, 16), (4, 4), (1.0, 1.0)) for shell in range(2, int(8 * away))]
        before = sum(grid.rows * grid.columns for grid in grids)
        assert 1.3 * min(sizes) / LEAST > before / shadow_frusta.FRUSTUM
    # Whoever needs an answer for each ray gets it.
    assert sum(len(rows) for rows, *_ in shadow_frusta.shadow_frusta(rays, coordinates, least=1)) == 4000


@pytest.mark.parametrize("bits", [4, 6])
def test_rays_that_a_grid_keeps_apart_are_one_frustum_of_the_coarsest_such_grid(bits):
    side = 1 << bits
    slopes = np.stack(np.meshgrid(*[(2 * np.arange(side) + 1) / side - 1] * 2), axis=-1).reshape(-1, 2)
    offset = np.concatenate([slopes, np.ones((side * side, 1))], axis=1) / 4
    scene = cube(4)
    middle = np.mean(scene.bounds, axis=0)
    rays = ShadowRays(points=middle[None], surfaces=np.array([-1]), light=np.zeros(side * side, dtype=int),
                      targets=middle + offset * np.ptp(scene.bounds, axis=0).min(), normals=-offset)
    coordinates = PatchGeometry.of(scene, CONFIG.numbers).coordinates
    (rows, record, number), = shadow_frusta.shadow_frusta(rays, coordinates)
    assert record.column_bits == bits
    assert sorted(rows) == sorted(number) == list(range(side * side))


def test_no_shaded_point_of_a_convex_room_is_in_shadow():
    """Its walls meet the ends of their rays, in front of which the rays end."""
    scene = cube(4)
    rays, _ = drawn_rays(scene, 3000, 1, lights=2)
    hits = ShellingFrusta(scene).shadows(rays)
    assert hits.cast.mean() > 0.8
    assert not hits.blocked.any()


def test_ends_without_a_margin_would_shade_points_by_their_own_patches(monkeypatch):
    def without(directions, offset, normal):
        height = np.einsum("ki,ki->k", normal, offset)
        return np.abs(np.einsum("ki,ki->k", normal, directions) / np.where(height, height, 1))
    monkeypatch.setattr(shadow_frusta, "shadow_ends", without)
    scene = cube(4)
    assert ShellingFrusta(scene).shadows(drawn_rays(scene, 3000, 1, lights=2)[0]).blocked.mean() > 0.05


def test_double_precision_differs_within_the_bounds_of_edges_and_ends():
    check_against_double_precision(builtin_scene("cornell"), 5000)


SCENES = ("cornell", "lobby", "room1627", "cubes", "man", "phone", "city:2", "teapot:4", "tetra:4", "mountain:4",
          "rings:1", "balls:1", "gears:1", "tree:4")


@pytest.mark.nightly
@pytest.mark.parametrize("scene", [*SCENES, *range(6)], ids=str)
def test_of_a_million_rays_none_differs_from_double_precision_without_a_cause(scene):
    check_against_double_precision(soup(scene, 60) if isinstance(scene, int) else builtin_scene(scene), 50_000)


def check_against_double_precision(scene, count):
    rays, surfaces = drawn_rays(scene, count, 7)
    hits = ShellingFrusta(scene).shadows(rays)
    assert hits.cast.mean() > 0.8
    other, unexplained = differences(scene, rays, surfaces, hits)
    assert len(other) <= 0.002 * count
    assert not len(unexplained)
