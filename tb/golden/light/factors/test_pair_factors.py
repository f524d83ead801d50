import numpy as np
import pytest

from benchmarks.analytic import polygon_to_polygon
from benchmarks.closed_forms import c_11, c_14, c_41
from golden.light.factors.pair_factors import exchange_areas
from golden.scene.polygons import is_convex_quad
from tb.golden.light.cube import cube
from tb.golden.light.scenes import rectangle


def floor(x, y):
    return rectangle((0, 0, 0), (x, 0, 0), (0, y, 0))


def ceiling(x, y, z=1.0):
    return rectangle((0, 0, z), (0, y, 0), (x, 0, 0))


def wall(y, height):
    """Over the edge x = 0 of the floor."""
    return rectangle((0, 0, 0), (0, y, 0), (0, 0, height))


def random_triangle(generator, *corners):
    points = np.concatenate([np.reshape(corners, (-1, 3)), generator.normal(size=(3, 3))])[:3]
    return points[[0, 1, 2, 2]]


def area(patch):
    diagonals = patch[..., 2, :] - patch[..., 0, :], patch[..., 3, :] - patch[..., 1, :]
    return np.linalg.norm(np.cross(*diagonals), axis=-1) / 2


@pytest.mark.parametrize(("x", "y"), [(1, 1), (2, 0.5), (10, 10), (0.1, 0.3), (1, 100), (0.02, 0.03)])
def test_opposed_rectangles_c11(x, y):
    factor = exchange_areas(floor(x, y)[None], ceiling(x, y)[None])[0] / (x * y)
    assert factor == pytest.approx(c_11(x, y), rel=0, abs=1e-9)


@pytest.mark.parametrize(("w", "h"), [(1, 1), (1, 2), (2, 1), (0.05, 3), (5, 0.1), (0.001, 1)])
def test_rectangles_with_a_common_edge_c14(w, h):
    factor = exchange_areas(floor(w, 1)[None], wall(1, h)[None])[0] / w
    assert factor == pytest.approx(c_14(w, h), rel=0, abs=1e-12)


def test_an_l_of_rectangles_that_touch_in_a_corner():
    # By the algebra of factors from C-14: the floor's far half to the wall over the other half of the edge.
    both = exchange_areas(floor(1, 2)[None], wall(2, 1)[None])[0]
    half = exchange_areas(floor(1, 1)[None], wall(1, 1)[None])[0]
    corner = exchange_areas(rectangle((0, 1, 0), (1, 0, 0), (0, 1, 0))[None], wall(1, 1)[None])[0]
    assert corner == pytest.approx(both / 2 - half, rel=0, abs=1e-13)


def test_coaxial_discs_c41():
    sides = 128
    angle = 2 * np.pi * np.arange(sides + 1) / sides
    rim = np.sqrt(2 * np.pi / sides / np.sin(2 * np.pi / sides)) * np.stack(
        [np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    middle = np.zeros((sides, 3))
    lower = np.stack([middle, rim[:-1], rim[1:], rim[1:]], axis=1)
    upper = np.add(np.stack([middle, rim[1:], rim[:-1], rim[:-1]], axis=1), (0, 0, 1))
    total = sides * exchange_areas(np.repeat(lower[:1], sides, axis=0), upper).sum() / np.pi
    assert total == pytest.approx(c_41(1, 1), rel=0, abs=1e-6)


@pytest.mark.parametrize("shared", [0, 1, 2], ids=["apart", "a common corner", "a common edge"])
def test_triangles_behind_each_others_planes(shared):
    generator = np.random.default_rng(shared)
    for _ in range(4):
        first = random_triangle(generator)
        second = random_triangle(generator, *first[:shared])
        for one in (first, first[[0, 2, 1, 1]]):
            expected = polygon_to_polygon(one[:3], second[:3], tolerance=1e-7) * area(one)
            got = exchange_areas(np.stack([one, second]), np.stack([second, one]))
            np.testing.assert_allclose(got, expected, rtol=0, atol=1e-7 * area(one))
            assert got[0] == pytest.approx(got[1], rel=0, abs=1e-12)


def test_far_pairs_by_points_equal_the_contours():
    # Four times the points of a patch's quarters are so much nearer to each other that another rule serves them.
    generator = np.random.default_rng(4)
    for distance in np.geomspace(1.5, 60, 30):
        first = np.subtract(floor(*generator.uniform(0.3, 1, size=2)), (0.4, 0.4, 0))
        second = ceiling(1, 1, distance) + generator.uniform(-1, 1, size=3) * [distance, distance, 0]
        quarters = [(a[k] + a) / 2 for a in (first, second) for k in range(4)]
        one, other = np.repeat(quarters[:4], 4, axis=0), np.tile(quarters[4:], (4, 1, 1))
        whole = exchange_areas(first[None], second[None])[0]
        assert exchange_areas(one, other).sum() == pytest.approx(whole, rel=0, abs=1e-8 * area(first))


@pytest.mark.parametrize("scale", [1e-6, 1, 1e6])
def test_a_cube_closes_at_any_scale_and_place(scale):
    patches = np.add(cube(3).vertices, (100, -20, 3)) * scale
    pairs = np.divmod(np.arange(len(patches)**2), len(patches))
    rows = exchange_areas(patches[pairs[0]], patches[pairs[1]]).reshape(len(patches), -1).sum(axis=1)
    np.testing.assert_allclose(rows / area(patches), 1, rtol=0, atol=1e-9)


def test_nothing_is_exchanged_behind_or_within_a_plane():
    low, high = floor(1, 1), ceiling(1, 1)
    pairs = [(low, high[::-1]), (low[::-1], high), (low, np.add(low, (2, 0, 0))), (low, np.add(low[::-1], (0, 1, 0)))]
    np.testing.assert_array_equal(exchange_areas(*np.moveaxis(np.array(pairs), 1, 0)), 0)


def test_a_patch_through_the_others_plane_counts_with_its_front_part_alone():
    through = rectangle((0, 0, -1), (0, 1, 0), (0, 0, 2))
    got = exchange_areas(floor(1, 1)[None], through[None])[0]
    assert got == pytest.approx(c_14(1, 1), rel=0, abs=1e-13)


def rounded_rectangles(count=60):
    """Those of rectangles in any direction, in 3 to 9 decimals, that are patches: as written, exact, decimals."""
    generator = np.random.default_rng(60)
    for number in range(count):
        decimals = 3 + number % 7
        turn = np.linalg.qr(generator.normal(size=(3, 3)))[0]
        width, height = generator.uniform(0.3, 3, size=2) * (1 if decimals > 4 else 100)
        exact = floor(width, height) @ turn + generator.uniform(-5, 5, size=3)
        if is_convex_quad(exact.round(decimals)[None])[0]:
            yield exact.round(decimals), exact, decimals


def test_no_rectangle_sees_itself_or_its_back_however_it_was_rounded():
    patches = np.array([written for written, _, _ in rounded_rectangles()])
    assert len(patches) > 40
    np.testing.assert_array_equal(exchange_areas(patches, patches), 0)
    np.testing.assert_array_equal(exchange_areas(patches, patches[:, ::-1]), 0)


def test_rounded_rectangles_exchange_what_exact_ones_do():
    for written, exact, decimals in rounded_rectangles(28):
        normal = np.cross(exact[1] - exact[0], exact[3] - exact[0])
        for lifted in (0.5, 2):  # the other one stands on an edge, or is opposite
            height = lifted * normal / np.linalg.norm(normal)**0.5
            others = exact[[0, 3, 3, 0]] + [[0], [0], [1], [1]] * height, exact[::-1] + height
            for other in others:
                got = exchange_areas(written[None], other.round(decimals)[None])[0]
                expected = exchange_areas(exact[None], other[None])[0]
                # A shift by d of a patch of width w changes the exchange area by at most d over w of the area, twice.
                width = min(np.linalg.norm(exact[1] - exact[0]), np.linalg.norm(exact[3] - exact[0]))
                assert got == pytest.approx(expected, rel=0, abs=10 * 10.0**-decimals / width * area(exact))


def test_a_bent_quad_exchanges_no_more_than_its_bend_with_a_patch_in_its_plane():
    generator = np.random.default_rng(6)
    flat = rectangle((-0.5, -0.5, 0), (1, 0, 0), (0, 1, 0))
    for _ in range(40):
        bend = 10.0**-generator.uniform(3, 9)
        bent = flat + bend * np.array([[1], [-1], [1], [-1]]) * (0, 0, 1)
        # Beyond an edge, in a plane that may pass between the corners.
        other = rectangle((0.5, -1, 0), (1, 0, 0), (0, 2, 0))
        other[:, 2] = other[:, :2] @ generator.uniform(-1.5, 1.5, size=2) * bend
        for patch in (other, other[::-1]):
            assert 0 <= exchange_areas(bent[None], patch[None])[0] <= 4 * bend
