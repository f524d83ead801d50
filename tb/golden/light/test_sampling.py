import numpy as np
import pytest
from scipy import stats

from golden.light.sampling import mix, pixel_ranks, sobol, uniform

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
    points = sobol(mix(5, pixel), 6, sample)
    np.testing.assert_array_equal(sobol(mix(5, pixel[some]), 6, sample[some]), points[some])


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


def one_in_each(points, columns, rows):
    """Whether C points of the unit square lie one in each of C equal rectangles."""
    number = cells(points[:, 0], columns) * rows + cells(points[:, 1], rows)
    return sorted(number.tolist()) == list(range(columns * rows))


@pytest.mark.parametrize(("count", "rank"), [(64, 0), (64, 5), (1, 3), (8, (1 << 29) - 1), (8, 1 << 29), (64, 1 << 40)])
def test_as_many_points_as_a_power_of_two_lie_one_in_each_rectangle(count, rank):
    for points in sobol(mix(3, np.arange(20)), count, rank):
        for columns in (1 << bit for bit in range(count.bit_length())):
            assert one_in_each(points, columns, count // columns)


@pytest.mark.parametrize(("count", "side"), [(1, 8), (2, 4), (8, 2), (4, 16)])
def test_points_of_a_square_of_pixels_lie_one_in_each_rectangle(count, side):
    row, column = (grid.ravel() for grid in np.mgrid[:32, :48])
    points = sobol(np.full(len(row), mix(7)), count, pixel_ranks(column, row))
    square = row // side * 48 + column // side
    for number in np.unique(square):
        together = points[square == number].reshape(-1, 2)
        for columns in (1, 2, len(together) // 2, len(together)):
            assert one_in_each(together, columns, len(together) // columns)


def test_pixels_of_the_largest_picture_have_ranks_of_their_own():
    column, row = np.array([0, 16383, 0, 16383, 5, 6]), np.array([0, 0, 16383, 16383, 6, 5])
    assert pixel_ranks(column, row).tolist() == [0, 0x5555555, 0xAAAAAAA, 0xFFFFFFF, 57, 54]


def test_neighbouring_pixels_err_in_opposite_ways():
    """The error of an edge falls with the points' number to the power of 3/4: by 8 in 4 x 4 pixels, at random by 4."""
    row, column = (grid.ravel() for grid in np.mgrid[:128, :128])
    x, y = np.moveaxis(sobol(np.full(1 << 14, mix(1)), 4, pixel_ranks(column, row)), 2, 0)
    error = ((x + 0.6 * y < 0.7).mean(axis=1) - (0.7 - 0.3)).reshape(128, 128)
    assert abs(error.mean()) < 0.002
    assert error.reshape(32, 4, 32, 4).mean(axis=(1, 3)).std() < 0.75 * error.std() / 4


@pytest.mark.parametrize(("count", "share"), [(4, 0.85), (16, 0.5), (64, 0.3)])
@pytest.mark.parametrize("integrand", [lambda x, y: x, lambda x, y: y, lambda x, y: x * y, lambda x, y: x * x + y < 1],
                         ids=["x", "y", "xy", "edge"])
def test_points_integrate_without_bias_and_better_than_at_random(count, share, integrand):
    """Of n squares an edge crosses up to two in each row, in which a share of 0 to 1 is hit: 1/6 is its variance."""
    known, spread = (f(integrand(*np.random.default_rng(1).random((2, 1 << 18)))) for f in (np.mean, np.std))
    means = integrand(*np.moveaxis(sobol(mix(3, np.arange(1 << 12)), count), 2, 0)).mean(axis=1)
    assert means.mean() == pytest.approx(known, rel=0, abs=4 * (means.std() / 2**6 + spread / 2**9))
    edge = np.sqrt(2 * np.sqrt(count) / 6) / count
    assert means.std() < (edge if integrand(1.0, 1.0) is False else share * spread / np.sqrt(count))


def test_every_point_of_a_sequence_is_uniform_over_its_scramblings():
    points = sobol(mix(9, np.arange(1 << 14)), 5)
    for point in np.moveaxis(points, 1, 0):
        assert_equally_often(cells(point[:, 0], 16) * 16 + cells(point[:, 1], 16), 256)


def test_sequences_of_two_uses_are_independent():
    """Also number by number, as where a ray's direction comes from one and its shadow ray's from the other."""
    one, other = (sobol(mix(use, np.arange(1 << 6)), 1 << 8)[..., 0].ravel() for use in (4, 7))
    assert_equally_often(cells(one, 16) * 16 + cells(other, 16), 256)
