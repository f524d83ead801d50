"""Traversal units join the clusters that need them most."""

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.engine.ctu.sector import Sector
from radiosity.machines.paper.unit_pool import join_units, sector_cuts

SECTIONS = [Sector(16 * number, 16 * number + 16, 0, 16) for number in range(4)]


@pytest.mark.parametrize(("steps", "units", "expected"), [
    ((1, 1, 1, 1), 4, (1, 1, 1, 1)), ((1, 1, 1, 1), 8, (2, 2, 2, 2)), ((8, 1, 1, 1), 8, (4, 2, 1, 1)),
    ((100, 1, 1, 1), 8, (4, 2, 1, 1)), ((3, 4, 1, 1), 6, (2, 2, 1, 1)), ((0, 0, 0, 0), 5, (2, 1, 1, 1))])
def test_the_most_steps_for_a_unit_get_as_many_again(steps, units, expected):
    assert join_units(steps, SECTIONS, units=units) == expected


def test_a_section_has_no_more_units_than_parts():
    sections = [Sector(0, 1, 0, 1), Sector(1, 3, 0, 1), Sector(3, 5, 0, 2)]
    assert join_units((100, 50, 1), sections, units=32) == (1, 2, 4)


def test_too_few_units():
    with pytest.raises(InputError, match=r"must be at least 4, one for each cluster, not 3"):
        join_units((1, 1, 1, 1), SECTIONS, units=3)


def test_sectors_are_parts_of_equal_steps():
    steps = np.zeros((16, 64))
    steps[:, 16:24], steps[:, 24:32] = 3, 1
    sectors = sector_cuts(steps, SECTIONS[1], units=4)
    assert [(one.first_column, one.end_column) for one in sectors] == [(16, 21), (16, 21), (21, 32), (21, 32)]
    assert sum(one.rays for one in sectors) == SECTIONS[1].rays
    sums = [steps[one.first_row:one.end_row, one.first_column:one.end_column].sum() for one in sectors]
    assert sums == [120, 120, 136, 136]
