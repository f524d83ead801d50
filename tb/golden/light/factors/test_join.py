from dataclasses import replace

import numpy as np
import pytest

from golden.light.factors.join import join
from golden.light.factors.row_block import RowBlock

AREA = np.array([1.0, 2.0, 4.0])
RAYS, ERROR = 100, 0.1


def block(rows, *, sky=0, back=0, hidden=0.0):
    """Rows of entries (column, hits, factor, error)."""
    entries = [entry for row in rows for entry in row]
    column, hits, factor, error = (np.array(values) for values in zip(*entries, strict=True)) if entries else [[]] * 4
    return RowBlock(start=np.cumsum([0, *map(len, rows)]), column=np.array(column, int),
                    hits=np.array(hits, int), factor=np.array(factor, float), error=np.array(error, float),
                    rays=np.full(len(rows), RAYS), sky=np.full(len(rows), sky / RAYS), back=np.full(len(rows), back),
                    sky_error=np.full(len(rows), sky / 1e4), sky_patches=np.zeros((len(rows), 0), int),
                    hidden_error=np.full(len(rows), hidden))


def joined(*blocks):
    return join(blocks, area=AREA, error=ERROR)


def test_hits_of_both_hemispheres_count_by_their_exposure():
    nan = np.nan
    result = joined(block([[(1, 3, nan, nan)], [(0, 2, nan, nan)], []]))
    expected = 5 / (RAYS / 1 + RAYS / 2)
    assert result.F[0, 1] == pytest.approx(expected)
    assert result.F[1, 0] == pytest.approx(expected / 2)
    assert result.error[0, 1] == pytest.approx(np.sqrt(5.5) / (RAYS / 1 + RAYS / 2))


def test_one_direction_is_enough():
    nan = np.nan
    result = joined(block([[], [], [(0, 1, nan, nan)]]))
    assert result.F[0, 2] == pytest.approx(1 / (RAYS + RAYS / 4))
    assert result.F[2, 0] == pytest.approx(result.F[0, 2] / 4)


def test_hits_give_at_most_the_error_from_the_smaller_patch():
    nan = np.nan
    result = joined(block([[], [(2, 90, nan, nan)], []]))
    assert result.F[1, 2] == pytest.approx(ERROR)
    assert result.error[1, 2] == pytest.approx(ERROR / 2)


def test_what_segments_measured_counts_alone():
    result = joined(block([[(1, 60, 0.25, 0.01)]]), block([[(0, 7, np.nan, np.nan)], [(0, 0, 0.125, 0.0)]]))
    assert result.F[0, 1] == 0.25
    assert result.F[1, 0] == 0.125
    assert (result.error[0, 1], result.error[1, 0]) == (0.01, 0.005)
    assert (result.F[2, 0], result.F[0, 2]) == (0.125, 0.5)
    assert result.error.nnz == 4
    assert result.error[0, 2] == 0


def test_the_surer_of_two_measurements_counts():
    for errors in ((0.01, 0.0001), (0.0001, 0.01)):
        result = joined(block([[(1, 0, 0.2, errors[0])], [(0, 0, 0.125, errors[1])], []]))
        assert result.F[0, 1] == (0.25 if errors[1] < errors[0] else 0.2)
        assert result.error[0, 1] == min(errors[0], 2 * errors[1])


def test_rows_of_more_rays_count_by_theirs():
    blocks = [block([[(1, 3, np.nan, np.nan)]]), block([[(0, 2, np.nan, np.nan)], []])]
    result = joined(replace(blocks[0], rays=np.array([400])), blocks[1])
    assert result.F[0, 1] == pytest.approx(5 / (400 / 1 + RAYS / 2))


def test_shares_outside():
    result = joined(block([[], []], sky=20, back=5, hidden=0.003), block([[]]))
    np.testing.assert_array_equal(result.sky, [0.2, 0.2, 0])
    np.testing.assert_array_equal(result.sky_error, [0.002, 0.002, 0])
    np.testing.assert_array_equal(result.back, [0.05, 0.05, 0])
    assert result.back_error[0] > 0
    assert result.back_error[2] == 0
    assert result.hidden_error == 0.003
    np.testing.assert_allclose(result.unseen_error, 2 / (RAYS + 4))


def test_all_else_in_a_row_measures_the_sky_once_more():
    result = joined(block([[(1, 60, 0.25, 0.003)], [], []], sky=300, back=0))
    others = np.array([0.003, 0.0015, 0])**2 + (2 / (RAYS + 4))**2
    np.testing.assert_allclose(result.closed_sky_error, 1 / np.sqrt(1 / 0.03**2 + 1 / others))
