"""Blocks of patches travel around the ring, one node to the left in each step, for all rows of the slowest node."""

import numpy as np
import pytest

from radiosity.machines.common.assignment import assign
from radiosity.machines.common.hypercube import MESSAGES, WORDS, hypercube, ring
from radiosity.machines.gather.circulation import circulate
from radiosity.machines.gather.node_memory import PATCH_WORDS
from tb.radiosity.machines.gather.nodes import drawn_work

pytestmark = pytest.mark.usefixtures("interpreted")


def restated(rows, held, work):
    """The ends as maxima along the ring: a node projects, sends a copy, and needs what its neighbour sent before."""
    nodes, timing, around = held.nodes, work.timing, ring(held.nodes)
    block = np.empty(len(held.order), dtype=int)
    block[held.order] = np.repeat(np.arange(nodes), held.sizes)
    pairs, words = work.of_blocks(block, nodes), PATCH_WORDS * held.sizes
    time = dict.fromkeys(range(nodes), 0)
    for turn in range(max(map(len, rows))):
        came = dict.fromkeys(range(nodes), 0)
        for step in range(nodes):
            sent = {}
            for place, node in enumerate(around):
                at = around[(place + step) % nodes]
                copies = words[at] * ((step > 0) + (step < nodes - 1)) * timing.operation
                busy = copies + pairs[rows[node][turn], at] if turn < len(rows[node]) else copies
                if turn < len(rows[node]):
                    busy += (step == 0) * work.clearing + (step == nodes - 1) * work.summing
                time[node] = max(time[node], came[node]) + busy
                if step < nodes - 1:
                    time[node] += timing.setup
                    sent[around[place - 1]] = time[node] + words[at] * timing.word
            came = sent
    return [time[node] for node in range(nodes)]


@pytest.mark.parametrize(("nodes", "patches"), [(1, 5), (2, 8), (4, 13), (8, 20)])
def test_times_are_maxima_along_the_ring(nodes, patches):
    work, held = drawn_work(7, patches), assign("random", patches, nodes)
    cube = hypercube(nodes, work.timing)
    rows = [held.patches(node) for node in range(nodes)]
    assert circulate(rows, held, work, cube, np.zeros(nodes)).ends.tolist() == restated(rows, held, work)


def test_words_are_the_rounds_times_all_blocks_but_the_last():
    """A node with fewer rows sends blocks on for the others: 13 patches on 4 nodes take 4 rounds of all nodes."""
    work, held = drawn_work(1, 13), assign("scattered", 13, 4)
    cube = hypercube(4, work.timing)
    circulate([held.patches(node) for node in range(4)], held, work, cube, np.zeros(4))
    assert cube.sent[:4, MESSAGES].tolist() == [4 * 3] * 4
    assert cube.sent[:, WORDS].sum() == 4 * 3 * 13 * PATCH_WORDS


def test_a_row_is_projected_once_with_each_block():
    """Without messages' times the only node with a row takes its time alone."""
    work, held = drawn_work(2, 8), assign("tiled", 8, 4)
    timing = type(work.timing)(operation=1, setup=0, word=0)
    work.timing = timing
    found = circulate([held.patches(0)[:1], *[held.patches(0)[:0]] * 3], held, work, hypercube(4, timing), np.zeros(4))
    assert found.ends[0] == work.of_rows[0] + PATCH_WORDS * 2 * 6
    assert found.ended.tolist() == [found.ends[0], *[0] * 7]
