"""Cells hold the patches that touch them, in G coordinates; every number passes a filter once."""

import numpy as np
import pytest

from golden.engine.config import Numbers
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.memsys.patches.filter import Filter
from golden.engine.scene.g_coordinates import GCoordinates
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


def test_long_lists_have_the_same_patches_evenly_mixed():
    count, run, parts = 4096, 64, 8
    vertices = np.zeros((count, 4, 3), dtype=np.int64)
    vertices[:, :, 0] = np.where(np.arange(count) < 1000, 0, 1 << 11)[:, None]
    plain, same, mixed = (CellTable(vertices, cell=1 << 10, ascending=most) for most in (None, count, 1000))
    np.testing.assert_array_equal(same.patches.read(np.arange(count)), np.arange(count))
    for name in "pointer", "count":
        np.testing.assert_array_equal(getattr(mixed, name), getattr(plain, name))
    (short,), (long,) = np.flatnonzero(plain.count == 1000), np.flatnonzero(plain.count == count - 1000)
    for cell in short, long:
        own, other = (table.patches.read(table.entries(np.array([cell]))) for table in (plain, mixed))
        np.testing.assert_array_equal(np.sort(other), own)
        if cell == short:
            np.testing.assert_array_equal(other, own)
            continue
        # Each run has as many patches of each part of the list.
        part = (other - own[0]) * parts // len(own)
        for begin in range(0, len(own) - run + 1, run):
            found = np.bincount(part[begin:begin + run], minlength=parts)
            assert found.max() - found.min() <= 3


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
