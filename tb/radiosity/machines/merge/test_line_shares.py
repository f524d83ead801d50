"""The screen is divided among regions by lines: equally, recursively, or by packing."""

import numpy as np
import pytest

from golden.base.errors import InputError
from radiosity.machines.merge.line_shares import DIVISIONS, divide_lines

pytestmark = pytest.mark.usefixtures("interpreted")


def loads(shares, counts):
    return np.array([counts[shares.order[first:last]].sum() for first, last in zip(
        shares.bounds[:-1], shares.bounds[1:], strict=True)])


def drawn(seed, lines=400):
    rng = np.random.default_rng(seed)
    return rng.integers(1, 300, lines) * (rng.random(lines) < 0.9) * (np.arange(lines) > lines // 5)


@pytest.mark.parametrize("division", DIVISIONS)
@pytest.mark.parametrize("regions", [1, 2, 16, 256])
def test_each_line_is_in_one_region_and_those_of_a_region_have_consecutive_numbers(division, regions):
    counts = drawn(regions)
    shares = divide_lines(division, counts, regions)
    assert np.array_equal(np.sort(shares.order), np.arange(400))
    assert np.array_equal(shares.order[shares.number], np.arange(400))
    filled = np.count_nonzero(counts) if division == "packed" else 400
    assert (shares.bounds[0], shares.bounds[-1], len(shares.bounds)) == (0, filled, regions + 1)
    assert (np.diff(shares.bounds) >= (division != "packed")).all()


def test_recursion_cuts_at_the_most_equal_halves():
    counts = np.array([9, 1, 1, 1, 4, 4, 2, 2])
    assert divide_lines("recursive", counts, 2).bounds.tolist() == [0, 4, 8]
    assert divide_lines("recursive", counts, 4).bounds.tolist() == [0, 1, 4, 5, 8]


def test_a_cut_is_the_best_of_all():
    for seed in range(20):
        counts = drawn(seed, 60)
        bounds = divide_lines("recursive", counts, 2).bounds
        halves = [abs(counts[:cut].sum() - counts[cut:].sum()) for cut in range(1, 60)]
        assert abs(counts[:bounds[1]].sum() - counts[bounds[1]:].sum()) == min(halves)


def test_the_heaviest_line_goes_to_the_lightest_region():
    shares = divide_lines("packed", np.array([3, 0, 9, 5, 4, 4]), 2)
    # 9 to region 0, 5 and 4 to region 1, 4 (9 each) to region 0, 3 to region 1.
    assert [sorted(shares.order[:2]), sorted(shares.order[2:5])] == [[2, 5], [0, 3, 4]]
    assert (shares.order[5], shares.bounds.tolist()) == (1, [0, 2, 5])


@pytest.mark.parametrize("seed", range(4))
def test_packing_is_nearer_to_equal_than_recursion(seed):
    counts = drawn(seed)
    imbalance = {}
    for division in ("recursive", "packed"):
        found = loads(divide_lines(division, counts, 16), counts)
        imbalance[division] = np.ptp(found) / found.mean()
    assert imbalance["packed"] < 0.5 * imbalance["recursive"]


@pytest.mark.parametrize(("words", "message"), [
    (("thirds", 4), "Division must be one of equal, recursive, packed, not 'thirds'"),
    (("equal", 512), "Nodes must be at most the 400 scanlines, not 512")])
def test_wrong_divisions_are_refused(words, message):
    with pytest.raises(InputError, match=message):
        divide_lines(words[0], drawn(0), words[1])
