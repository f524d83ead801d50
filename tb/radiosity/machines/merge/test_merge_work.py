"""Operations of a node are whole numbers of at least 0."""

import pytest

from radiosity.machines.merge.merge_work import MergeWork


def test_a_cell_takes_the_source_s_mean_of_table_4_2():
    """Merge times over (P - 1) / P of 160,000 cells, less two words of 1.43 us."""
    sixteen = [2015, 1940, 1930, 1958, 2043, 1958]
    eight = [1941, 1882, 1798, 1881]
    constants = [time / (160 * 15 / 16) for time in sixteen] + [time / (160 * 7 / 8) for time in eight]
    assert min(constants) > 12.8
    assert max(constants) < 13.9
    assert MergeWork().cell == pytest.approx(1000 * sum(constants) / len(constants) - 2 * 1430, abs=50)


def test_wrong_operations_are_refused():
    with pytest.raises(ValueError, match="Pixel must be at least 0, not -1"):
        MergeWork(pixel=-1)
    with pytest.raises(TypeError, match="Cell must be an int"):
        MergeWork(cell=1.5)
