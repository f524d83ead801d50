from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.light.factors.join import join
from golden.light.factors.row_block import RowBlock
from tb.lib.schedules import SETTINGS

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
                    sky_rays=np.full(len(rows), RAYS),
                    hidden_error=np.full(len(rows), hidden))


def joined(*blocks):
    return join(blocks, area=AREA, error=ERROR)


@st.composite
def drawn_rows(draw):
    """Areas, rays and entries of up to four sides: rows without entries, of one direction, measured or only hit."""
    count = draw(st.integers(1, 4))
    sides = st.sampled_from((0.5, 1.0, 4.0))
    rows = []
    for row in range(count):
        columns = [column for column in range(count) if column != row and draw(st.booleans())]
        rows.append([(column, draw(st.integers(0, 40)), *draw(st.sampled_from((
            (np.nan, np.nan), (0.125, 0.01), (0.0625, 0.001), (0.03125, 0.0))))) for column in columns])
    return [draw(sides) for _ in rows], [draw(st.sampled_from((50, 100, 400))) for _ in rows], rows


@settings(SETTINGS, max_examples=80)
@given(drawn_rows(), st.data())
def test_pairs_are_joined_by_their_definition_whatever_the_blocks(drawn, data):
    area, rays, rows = drawn
    blocks, first = [], 0
    while first < len(rows):
        last = data.draw(st.integers(first + 1, len(rows)))
        blocks.append(replace(block(rows[first:last]), rays=np.array(rays[first:last])))
        first = last
    result = join(blocks, area=np.array(area), error=ERROR)
    for i, j in combinations(range(len(rows)), 2):
        entries = [next((entry for entry in rows[row] if entry[0] == column), None) for row, column in ((i, j), (j, i))]
        seen = [(side, *entry[1:]) for side, entry in zip((i, j), entries, strict=True) if entry]
        exposure = rays[i] / area[i] + rays[j] / area[j]
        measured = [(error * area[side], factor * area[side]) for side, _, factor, error in seen if not np.isnan(error)]
        if measured:
            # Of equally sure ones that of the second side.
            deviation, exchange = min(measured[::-1], key=lambda one: one[0])
        else:
            hits, most = sum(entry[1] for entry in seen), ERROR * min(area[i], area[j])
            exchange = min(hits / exposure, most) if seen else 0
            deviation = min(np.sqrt(hits + 0.5) / exposure, most / 2) if seen else 0
        for one, other in ((i, j), (j, i)):
            assert result.F[one, other] == pytest.approx(exchange / area[one])
            assert result.error[one, other] == pytest.approx(deviation / area[one])
    assert result.F.nnz == result.error.nnz == len(
        {frozenset((row, entry[0])) for row, entries in enumerate(rows) for entry in entries}) * 2


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
