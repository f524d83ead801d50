"""Splits take the messages of their steps: sums over each channel, boxes for partners, and faces from each to all."""

import numpy as np
import pytest

from radiosity.machines.common.hypercube import MESSAGES, WORDS, hypercube
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.merge.screen_split import SPLITTERS, NodeFaces
from radiosity.machines.merge.split_programs import FACE_WORDS, face_moves, split_ends

pytestmark = pytest.mark.usefixtures("interpreted")

SILENT = NodeTiming(operation=1, setup=0, word=0)
NODES, LINES, COLUMNS = 8, 64, 32


def sent(splitter, moves, shape=(LINES, COLUMNS), timing=SILENT, count=160):
    cube = hypercube(NODES, timing)
    ends = split_ends(splitter, moves, count, 500, cube, timing, shape=shape)
    return cube.sent[:NODES], ends


def test_faces_go_from_their_block_to_all_that_need_them():
    faces = NodeFaces(np.array([0, 3, 5]), np.array([0, 1, 3, 2, 3]))
    assert face_moves(faces, 4).tolist() == [[2, 0], [1, 2]]


@pytest.mark.parametrize(("splitter", "words", "messages"), [
    ("hs", 3 * 2 * LINES, 3), ("rs", 3 * 2 * LINES + 3 * 2 * COLUMNS * 4 + 7 * 2, 3 + 3 + 3),
    ("rrs", 6 * 2 * (LINES + COLUMNS) + 3 * 10 * 2 + 7 * 4, 6 + 3 + 3), ("mahd", 3 * LINES * COLUMNS, 3),
    ("hcs", 3 * LINES * COLUMNS, 3), ("gs", 3 * (3 * LINES * COLUMNS - LINES - COLUMNS), 3)])
def test_counts_of_all_nodes_are_added(splitter, words, messages):
    """Beside the faces: 20 for each node of 8, none of which it has already."""
    moves = np.zeros((NODES, NODES), dtype=np.int64)
    moves[np.arange(NODES), np.arange(NODES) ^ 5] = 20
    found, _ = sent(splitter, moves)
    faces = FACE_WORDS * 20
    # From each to all: 7 steps, each with a barrier of 3 exchanges.
    assert (found[:, WORDS] == words + faces).all()
    assert (found[:, MESSAGES] == messages + 7 * (1 + 3)).all()


@pytest.mark.parametrize("splitter", SPLITTERS)
def test_boxes_are_those_of_the_faces_that_are_dealt(splitter):
    """Without times of messages a split does not depend on how many nodes need each face, but on how many are dealt."""
    once, often, more = (sent(splitter, np.full((NODES, NODES), each), count=count)[1].max()
                         for each, count in ((20, 1280), (160, 1280), (20, 2560)))
    assert once == often < more


def test_splits_by_lines_take_less_than_those_by_a_mesh():
    moves = np.full((NODES, NODES), 50, dtype=np.int64)
    timing = NodeTiming(operation=50, setup=1000, word=100)
    ends = {splitter: sent(splitter, moves, timing=timing)[1].max() for splitter in SPLITTERS}
    assert min(ends, key=ends.get) == "hs"
    assert max(ends, key=ends.get) == "gs"
