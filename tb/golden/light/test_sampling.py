import numpy as np
import pytest
from scipy import stats

from golden.light.sampling import lattice, mix, uniform

# A test statistic further out than this by chance: once in a million.
RARE = 1e-6


@pytest.fixture
def pixels():
    """The uses of a small picture, as the renderer names them."""
    return mix(0, 2, np.arange(1 << 16), 0)


def cells(values, count):
    return (values * count).astype(int)


def assert_equally_often(number, count):
    assert stats.chisquare(np.bincount(number, minlength=count)).pvalue > RARE


def test_hashes_are_the_published_sequence_of_splitmix64():
    assert mix(0, np.arange(3)).tolist() == [0xE220A8397B1DCDAF, 0x6E789E6AA1B965F4, 0x06C45D188009454F]


def test_numbers_depend_on_their_keys_alone():
    pixel, sample = np.divmod(np.arange(600), 4)
    whole = uniform(mix(5, 2, pixel, sample), 3)
    some = np.random.default_rng(1).permutation(600)[:77]
    np.testing.assert_array_equal(uniform(mix(5, 2, pixel[some], sample[some]), 3), whole[some])
    assert uniform(mix(5, 2, 11, 3), 3) == whole[11 * 4 + 3]
    points = lattice(mix(5, pixel), 6)
    np.testing.assert_array_equal(lattice(mix(5, pixel[some]), 6), points[some])


@pytest.mark.parametrize("keys", [(1, 2, 3, 4), (0, 2, 3, 5), (0, 3, 2, 4), (0, 2, 3), (0, 2, 3, 4, 0)])
def test_every_key_its_position_and_the_seed_count(keys):
    assert mix(*keys) != mix(0, 2, 3, 4)


def test_large_seeds_and_keys_are_taken_without_complaint():
    assert len(np.unique(mix(2**63 - 1, np.array([0, 1, 2**40, 2**62])))) == 4


@pytest.mark.parametrize("dimension", range(6))
def test_numbers_are_uniform_in_the_unit_interval(pixels, dimension):
    values = uniform(pixels, dimension)
    assert values.min() >= 0
    assert values.max() < 1
    assert_equally_often(cells(values, 256), 256)


@pytest.mark.parametrize("step", [1, 2, 64, 256])
def test_neighbouring_pixels_have_independent_numbers(pixels, step):
    values = uniform(pixels, 2)
    assert_equally_often(cells(values[:-step], 16) * 16 + cells(values[step:], 16), 256)


@pytest.mark.parametrize(("first", "second"), [(0, 1), (2, 3), (1, 2), (0, 4)])
def test_dimensions_of_one_use_are_independent(pixels, first, second):
    assert_equally_often(cells(uniform(pixels, first), 16) * 16 + cells(uniform(pixels, second), 16), 256)


def test_samples_and_seeds_of_one_pixel_are_independent():
    seed, sample = (grid.ravel() for grid in np.mgrid[:256, :256])
    values = uniform(mix(seed, 2, 7, sample), 2).reshape(256, 256)
    assert_equally_often(cells(values[1:], 16).ravel() * 16 + cells(values[:-1], 16).ravel(), 256)
    assert_equally_often(cells(values[:, 1:], 16).ravel() * 16 + cells(values[:, :-1], 16).ravel(), 256)


@pytest.mark.parametrize("count", [1, 4, 16, 61, 256])
def test_lattice_points_keep_their_distance(count):
    """The nearest two of as many points at random are about 0.5 / count apart; a square grid keeps 1 / sqrt(count)."""
    points = lattice(mix(3, np.arange(4)), count)
    assert points.shape == (4, count, 2)
    assert points.min() >= 0
    assert points.max() < 1
    apart = np.abs(points[:, :, None] - points[:, None])
    apart = np.linalg.norm(np.minimum(apart, 1 - apart), axis=3) + 2 * np.eye(count)
    assert apart.min() > 0.3 / np.sqrt(count)


@pytest.mark.parametrize("count", [4, 9, 16, 61])
def test_first_coordinates_of_a_lattice_fall_one_into_each_equal_part(count):
    number = cells(lattice(mix(3, np.arange(50)), count)[..., 0], count)
    np.testing.assert_array_equal(np.sort(number, axis=1), np.tile(np.arange(count), (50, 1)))


@pytest.mark.parametrize(("count", "share"), [(4, 0.85), (16, 0.5), (64, 0.3)])
@pytest.mark.parametrize("integrand", [lambda x, y: x, lambda x, y: y, lambda x, y: x * y, lambda x, y: x * x + y < 1],
                         ids=["x", "y", "xy", "edge"])
def test_lattice_points_integrate_without_bias_and_better_than_points_at_random(count, share, integrand):
    known, spread = (f(integrand(*np.random.default_rng(1).random((2, 1 << 18)))) for f in (np.mean, np.std))
    means = integrand(*np.moveaxis(lattice(mix(3, np.arange(1 << 12)), count), 2, 0)).mean(axis=1)
    assert means.mean() == pytest.approx(known, rel=0, abs=4 * (means.std() / 2**6 + spread / 2**9))
    assert means.std() < share * spread / np.sqrt(count)


def test_every_point_of_a_lattice_is_uniform_over_its_shifts():
    points = lattice(mix(9, np.arange(1 << 14)), 5)
    for point in np.moveaxis(points, 1, 0):
        assert_equally_often(cells(point[:, 0], 16) * 16 + cells(point[:, 1], 16), 256)


@pytest.mark.parametrize(("count", "ranks"), [(1, 4), (2, 4), (3, 9)])
def test_uses_of_all_ranks_have_the_points_of_one_lattice(count, ranks):
    state = mix(3, np.full(ranks, 17))
    parts = lattice(state, count, np.arange(ranks), ranks)
    whole = lattice(state[:1], count * ranks)[0]
    assert parts.shape == (ranks, count, 2)
    assert np.sort(parts[..., 0].ravel()) == pytest.approx(np.sort(whole[:, 0]))
    assert np.sort(parts[..., 1].ravel()) == pytest.approx(np.sort(whole[:, 1]))
    # Each use alone covers the first dimension evenly.
    gaps = np.diff(np.sort(parts[..., 0], axis=1), axis=1)
    assert gaps == pytest.approx(1 / count)
