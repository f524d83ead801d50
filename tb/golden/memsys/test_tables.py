"""Cells hold the patches that touch them, in G coordinates; every number passes a filter once."""

import numpy as np
import pytest

from golden.config import Numbers
from golden.memsys.cell_table import CellTable
from golden.memsys.filter import Filter
from golden.scene.g_coordinates import GCoordinates
from tb.golden.soups import soup


@pytest.mark.parametrize("fraction", [0.5, 0.0625])
@pytest.mark.parametrize("seed", range(3))
def test_points_of_a_patch_lie_in_cells_that_hold_it(seed, fraction):
    scene = soup(seed)
    coordinates = GCoordinates.of(scene, Numbers())
    vertices = coordinates.integers(scene.vertices)
    table = CellTable(vertices, cell=coordinates.cell_size(fraction))
    u, v = np.random.default_rng(seed).random((2, 100, len(scene), 1))
    points = (1 - v) * ((1 - u) * vertices[:, 0] + u * vertices[:, 1]) + v * ((1 - u) * vertices[:, 3]
                                                                              + u * vertices[:, 2])
    points = np.concatenate([points, np.moveaxis(vertices, 1, 0)])
    index = ((points - table.lower) // table.cell).astype(np.int64)
    assert (index >= 0).all()
    assert (index < table.shape).all()
    number = table.number(index)
    for patch in range(len(scene)):
        holding = np.flatnonzero([patch in table.patches.read(table.entries(np.array([cell])))
                                  for cell in np.unique(number[:, patch])])
        assert len(holding) == len(np.unique(number[:, patch]))


def test_entries_are_the_lists_of_the_cells_one_after_the_other():
    scene = soup(1)
    coordinates = GCoordinates.of(scene, Numbers())
    table = CellTable(coordinates.integers(scene.vertices), cell=coordinates.cell_size(0.25))
    cells = np.random.default_rng(0).permutation(len(table))
    expected = [address for cell in cells
                for address in range(table.pointer[cell], table.pointer[cell] + table.count[cell])]
    np.testing.assert_array_equal(table.entries(cells), expected)
    assert sorted(expected) == list(range(len(table.patches)))


def test_a_number_passes_once_in_the_order_of_first_occurrence():
    numbers = Filter(10)
    np.testing.assert_array_equal(numbers.first(np.array([3, 1, 3, 7, 1])), [3, 1, 7])
    np.testing.assert_array_equal(numbers.first(np.array([7, 0, 3, 0])), [0])
    assert (numbers.seen, numbers.passed) == (9, 4)


@pytest.mark.parametrize("tag_bits", [1, 2, 8])
def test_a_new_generation_lets_everything_pass_again_also_when_tags_wrap(tag_bits):
    numbers = Filter(4, tag_bits=tag_bits)
    for _ in range(2 ** (tag_bits + 1)):
        np.testing.assert_array_equal(numbers.first(np.array([2, 1, 2])), [2, 1])
        assert len(numbers.first(np.array([1, 2]))) == 0
        numbers.clear()
