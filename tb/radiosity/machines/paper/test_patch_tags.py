"""Tags steer each patch to every section that its window meets."""

import numpy as np
import pytest

from golden.engine.icu.window import Window
from golden.engine.schedule.classification import classify
from golden.engine.schedule.sections import cut_sections
from radiosity.machines.paper.patch_tags import patch_tags, reached_sections

COLUMNS, ROWS = 64, 16


def window(*patches):
    return Window(*(np.array(value, dtype=np.int64) for value in zip(*patches, strict=True)))


@pytest.fixture(scope="module")
def drawn():
    rng = np.random.default_rng(5)
    partition = cut_sections(rng.random((ROWS, COLUMNS)), clusters=16)
    first_row = rng.integers(0, ROWS, 400)
    return partition, Window(rng.integers(0, COLUMNS, 400), rng.integers(0, 20, 400), first_row,
                             np.minimum(rng.integers(0, 8, 400), ROWS - first_row))


def test_a_bit_is_the_side_of_its_cut():
    partition = cut_sections(np.ones((ROWS, COLUMNS)), clusters=4)
    tags = patch_tags(partition, [window((2, 3, 1, 2), (40, 3, 1, 2), (2, 3, 12, 2), (40, 3, 12, 2))])
    assert tags.side.tolist() == [[False, False], [True, False], [False, True], [True, True]]
    assert not tags.both.any()
    assert [tags.destinations(patch).tolist() for patch in range(4)] == [[0], [2], [1], [3]]


def test_a_patch_on_a_cut_goes_to_both_sides():
    partition = cut_sections(np.ones((ROWS, COLUMNS)), clusters=4)
    tags = patch_tags(partition, [window((30, 4, 1, 2), (30, 4, 7, 2), (2, 3, 7, 2))])
    assert tags.both.tolist() == [[True, False], [True, True], [False, True]]
    assert [tags.destinations(patch).tolist() for patch in range(3)] == [[0, 2], [0, 1, 2, 3], [0, 1]]
    assert [tags.links(patch) for patch in range(3)] == [1 + 2 + 2, 1 + 2 + 4, 1 + 1 + 2]


def test_a_window_that_wraps_is_on_both_sides():
    partition = cut_sections(np.ones((ROWS, COLUMNS)), clusters=2)
    assert patch_tags(partition, [window((62, 4, 0, 1))]).destinations(0).tolist() == [0, 1]


def test_different_sides_of_two_parts_are_both_sides():
    """The halves of columns are cut at different rows: below the one cut is above the other."""
    work = np.ones((ROWS, COLUMNS))
    work[:4, :32], work[12:, 32:] = 50, 50
    partition = cut_sections(work, clusters=4)
    tags = patch_tags(partition, [window((30, 4, 7, 1))])
    assert reached_sections(partition, window((30, 4, 7, 1))).tolist() == [[False, True, True, False]]
    assert tags.destinations(0).tolist() == [0, 1, 2, 3]


def test_every_section_that_a_window_meets_is_a_destination(drawn):
    partition, windows = drawn
    tags, reached = patch_tags(partition, [windows]), reached_sections(partition, windows)
    home, more = classify(partition, windows), 0
    for patch in range(400):
        destinations = tags.destinations(patch).tolist()
        assert set(np.flatnonzero(reached[patch])) <= set(destinations)
        if tags.sent[patch] and not tags.both[patch].any():
            assert destinations == [home[patch]]
        more += len(destinations) > reached[patch].sum()
    assert more


def test_a_patch_without_rays_is_not_sent(drawn):
    partition, windows = drawn
    tags, empty = patch_tags(partition, [windows]), np.flatnonzero(windows.rays == 0)
    assert len(empty)
    assert all(len(tags.destinations(patch)) == tags.links(patch) == 0 for patch in empty)


def test_one_section_has_tags_without_bits():
    partition = cut_sections(np.ones((ROWS, COLUMNS)), clusters=1)
    tags = patch_tags(partition, [window((2, 3, 1, 2))])
    assert (tags.destinations(0).tolist(), tags.links(0)) == ([0], 1)
