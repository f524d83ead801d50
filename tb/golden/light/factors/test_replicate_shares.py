import numpy as np
import pytest
from scipy.special import ndtr, stdtr, stdtrit

from golden.light.factors.points import REPLICATES
from golden.light.factors.replicate_shares import replicate_shares


def shares_of(part, count):
    """Of ``count`` equal weights in each replicate."""
    part = np.asarray(part, dtype=float)
    return replicate_shares(np.full(part.shape, float(count)), part, np.full(len(part), float(count * REPLICATES)))


def test_tails_are_those_of_as_many_replicates():
    """Student's distribution, scaled to the normal one's share within two: its tails are heavier."""
    generator = np.random.default_rng(3)
    share, error = shares_of(generator.binomial(1000, 0.4, size=(20000, REPLICATES)), 1000)
    deviation = np.abs(share - 0.4) / error
    scale = stdtrit(REPLICATES - 1, ndtr(2)) / 2
    for multiple in (1, 2, 3, 4):
        expected = 2 * stdtr(REPLICATES - 1, -multiple * scale)
        assert np.mean(deviation > multiple) == pytest.approx(expected, abs=4 * np.sqrt(expected / len(share)))
    assert 4e-4 < expected < 1e-3


@pytest.mark.parametrize("met", [0, 10])
def test_without_variance_it_is_half_of_wilsons_bound(met):
    share, error = shares_of(np.full((1, REPLICATES), met), 10)
    assert share[0] == met / 10
    assert error[0] == pytest.approx(2 / (160 + 4))


def test_replicates_that_agree_have_an_error():
    share, error = shares_of(np.full((1, REPLICATES), 5), 10)
    assert share[0] == 0.5
    assert error[0] == pytest.approx(2 / (REPLICATES + 4) / 10)


def test_rare_ones_are_covered():
    generator = np.random.default_rng(2)
    share, error = shares_of(generator.binomial(60, 2e-3, size=(500, REPLICATES)), 60)
    assert (np.abs(share - 2e-3) <= 2 * error).mean() >= 0.95


def test_nothing_drawn():
    share, error = replicate_shares(np.zeros((1, REPLICATES)), np.zeros((1, REPLICATES)), np.zeros(1))
    assert (share[0], error[0]) == (0.5, 0.5)
