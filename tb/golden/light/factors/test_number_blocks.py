import numpy as np
import pytest

from golden.light.factors.number_blocks import number_blocks


@pytest.mark.parametrize("size", [1, 3, 7, 100])
def test_blocks_hold_all_numbers_of_all_runs_in_order(size):
    blocks = list(number_blocks(np.array([5, 0, 2, 9]), np.array([3, 0, 5, 1]), size))
    assert [len(number) for _, number in blocks] == [size] * (9 // size) + [9 % size] * (9 % size > 0)
    run, number = (np.concatenate(part) for part in zip(*blocks, strict=True))
    np.testing.assert_array_equal(run, [0, 0, 0, 2, 2, 2, 2, 2, 3])
    np.testing.assert_array_equal(number, [5, 6, 7, 2, 3, 4, 5, 6, 9])


def test_no_runs_give_no_block():
    assert not list(number_blocks(np.zeros(0, int), np.zeros(0, int), 4))
