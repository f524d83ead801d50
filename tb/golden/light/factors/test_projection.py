import numpy as np
import pytest
from scipy import sparse

from golden.light.factors.join import Estimate
from golden.light.factors.projection import _SLACKS, _Problem, project


def estimate(F, error, *, sky=None, sky_error=None):
    zeros = np.zeros(len(F))
    pattern = F + F.T > 0
    row, column = np.nonzero(pattern)
    F, error = (sparse.csr_array((values[row, column], (row, column)), shape=pattern.shape)
                for values in (F, np.broadcast_to(error, pattern.shape)))
    return Estimate(F=F, error=error, sky=zeros if sky is None else sky, back=zeros, back_error=zeros,
                    unseen_error=zeros, hidden_error=0.0, sky_error=zeros if sky_error is None else sky_error)


@pytest.fixture(scope="module")
def room():
    """True factors of a closed scene of 40 sides, of which half the pairs see each other, and their areas."""
    generator = np.random.default_rng(1)
    exchange = np.triu(generator.uniform(0.2, 1, size=(40, 40)) * (generator.uniform(size=(40, 40)) < 0.5), 1)
    exchange += exchange.T
    area = exchange.sum(axis=1)
    return exchange / area[:, None], area


@pytest.fixture(scope="module")
def noisy(room):
    """Reciprocal estimates with a relative standard error of 3 % each, and these errors."""
    F = room[0]
    noise = np.triu(np.random.default_rng(2).normal(size=F.shape).clip(-1.8, 1.8), 1)
    error = 0.03 * F
    return F + (noise + noise.T) * error, error


def test_rows_close_and_pairs_are_reciprocal(room, noisy):
    area = room[1]
    F, sky, back = project(estimate(*noisy), area=area)
    np.testing.assert_allclose(F.sum(axis=1), 1, rtol=0, atol=1e-12)
    exchange = F.toarray() * area[:, None]
    np.testing.assert_allclose(exchange, exchange.T, rtol=1e-15)
    assert not sky.any()
    assert not back.any()


def test_no_factor_moves_by_more_than_two_standard_errors_or_below_zero(room, noisy):
    F, error = noisy
    result = project(estimate(F, error), area=room[1])[0].toarray()
    assert (np.abs(result - F) <= 2 * error + 1e-8).all()
    assert result.min() >= 0
    assert (result[F == 0] == 0).all()
    assert np.abs(result - F).max() > 1e-3


def test_the_projection_lessens_the_error(room, noisy):
    F, area = room
    result = project(estimate(*noisy), area=area)[0].toarray()
    assert np.linalg.norm(result - F) < 0.99 * np.linalg.norm(noisy[0] - F)


def test_within_the_bounds_it_is_weighted_least_squares(room):
    F, area = room
    low, high = np.nonzero(np.triu(F))
    incidence = np.zeros((len(F), len(low)))
    incidence[low, np.arange(len(low))] = incidence[high, np.arange(len(low))] = 1
    exact = (F * area[:, None])[low, high]
    generator = np.random.default_rng(3)
    spread = exact * generator.uniform(0.01, 0.03, size=len(exact))
    given = exact + 0.3 * spread * generator.normal(size=len(exact)).clip(-2, 2)
    weighted = incidence * spread**2
    expected = given + weighted.T @ np.linalg.solve(weighted @ incidence.T, area - incidence @ given)
    matrix, error = np.zeros((2, *F.shape))
    for values, target in ((given, matrix), (spread, error)):
        target[low, high] = target[high, low] = values
    result = project(estimate(matrix / area[:, None], error / area[:, None]), area=area)[0].toarray()
    np.testing.assert_allclose((result * area[:, None])[low, high], expected, rtol=0, atol=1e-9)


def test_exact_factors_stay(room, noisy):
    F, error = noisy
    known = np.zeros(F.shape, dtype=bool)
    known[:5] = known[:, :5] = True
    rows = np.arange(len(F)) >= 5
    F, error = np.where(known, room[0], F), np.where(known, 0, error)
    result = project(estimate(F, error), area=room[1])[0].toarray()
    assert np.abs(result - F)[known].max() <= 1e-7
    assert np.abs(result.sum(axis=1) - 1)[rows].max() <= 1e-12


def test_the_sky_takes_what_factors_cannot(room):
    F, area = room
    given, error = np.full(len(F), 0.21), np.full(len(F), 0.01)
    result, sky, _ = project(estimate(0.8 * F, 1e-4 * F, sky=given, sky_error=error), area=area)
    np.testing.assert_allclose(result.sum(axis=1) + sky, 1, rtol=0, atol=1e-12)
    np.testing.assert_allclose(sky, 0.2, rtol=0, atol=2e-4)


def test_a_row_that_nothing_closes_stays_open_and_the_others_close(room, noisy):
    F, error = (values.copy() for values in noisy)
    F[7], error[7] = 0.5 * room[0][7], 1e-6
    F[:, 7], error[:, 7] = F[7] * room[1][7] / room[1], 1e-6
    sums = project(estimate(F, error), area=room[1])[0].sum(axis=1)
    assert sums[7] == pytest.approx(0.5, abs=1e-3)
    assert np.abs(np.delete(sums, 7) - 1).max() <= 1e-9


def test_a_row_that_need_not_close_pulls_nothing(room, noisy):
    F, area = noisy[0].copy(), room[1]
    F[7] *= 0.5
    F[:, 7] *= 0.5
    given, ignored = estimate(F, noisy[1]), np.arange(len(F)) == 7
    forced, left = (project(given, area=area, ignored=rows)[0] for rows in (None, ignored))
    assert np.abs(np.delete(left.sum(axis=1), 7) - 1).max() <= 1e-9
    assert left.sum(axis=1)[7] < forced.sum(axis=1)[7] < 0.6
    # All of the pull is that of the other rows.
    moved = [np.abs((one - given.F).toarray()[7]).sum() for one in (forced, left)]
    assert moved[1] < moved[0]


def test_only_the_row_that_nothing_closes_is_open_though_many_factors_are_at_their_bounds():
    generator = np.random.default_rng(5)
    exchange = np.triu(generator.uniform(0.2, 1, size=(40, 40)) * (generator.uniform(size=(40, 40)) < 0.1), 1)
    spread = np.triu(10**generator.uniform(-5, -1, size=(40, 40)) * exchange, 1)
    noise = generator.normal(size=(40, 40)).clip(-1.8, 1.8) * spread
    exchange, spread, noise = (values + values.T for values in (exchange, spread, noise))
    area = exchange.sum(axis=1)
    area[7] *= 1.5
    given = (exchange + noise) / area[:, None]
    sums = project(estimate(given, spread / area[:, None]), area=area)[0].sum(axis=1)
    np.testing.assert_array_equal(np.flatnonzero(np.abs(sums - 1) > 1e-9), [7])


def test_a_closed_reciprocal_estimate_stays(room):
    F, area = room
    result = project(estimate(F, 0.01 * F), area=area)[0].toarray()
    np.testing.assert_allclose(result, F, rtol=0, atol=1e-14)


def test_the_search_ends_when_all_rows_close(room, noisy, monkeypatch):
    """Two steps for each slack or fewer; what would follow them only moves roundings."""
    steps, step = [], _Problem._newton_step
    monkeypatch.setattr(_Problem, "_newton_step", lambda *given: steps.append(1) or step(*given))
    project(estimate(*noisy), area=room[1])
    assert 0 < len(steps) <= 2 * len(_SLACKS)


def test_a_row_of_which_no_ray_left_keeps_a_sky_of_zero(room, noisy):
    count = len(noisy[0])
    sky = project(estimate(*noisy, sky=np.zeros(count), sky_error=np.full(count, 0.01)), area=room[1])[1]
    assert not sky.any()


def test_exact_factors_of_a_small_side_stay_beside_large_ones():
    area = np.array([1.0, 1e4, 1e4])
    exchange = np.array([[0, 0.5 - 1e-5, 0.5], [0.5 - 1e-5, 0, 9999.5], [0.5, 9999.5, 0]])
    F = exchange / area[:, None]
    result = project(estimate(F, 0), area=area)[0].toarray()
    np.testing.assert_allclose(result[0], F[0], rtol=0, atol=2.1e-8)
