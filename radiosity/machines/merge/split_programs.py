"""Split programs: the time in which nodes split a screen, and send faces to the regions that they meet."""

import numpy as np

from radiosity.machines.common.collectives import concatenation, reduction
from radiosity.machines.common.hypercube import Hypercube
from radiosity.machines.common.node_programs import joined, run_program, work_step
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.merge.merge_programs import all_to_all_ends
from radiosity.machines.merge.screen_split import NodeFaces

__all__ = ["FACE_WORDS", "face_moves", "split_ends"]

FACE_WORDS = 13
"""Words of a face: 3 corners with a value each, and its number with the flag of an exterior one."""

_BOX_WORDS = 2
# Operations: corners moved and compared to make a box (3 x 28 + 12); 4 counts of a box in arrays, or its cells found
# (8); a cell tallied; what an entry of an array takes in a prefix sum and in a search; a cell on a curve; and
# a cell of each level of bisection.
_BOX, _COUNTS, _CELLS, _CELL, _ENTRY, _CURVE, _BISECTION = 96, 4, 8, 4, 3, 40, 400


def face_moves(faces: NodeFaces, count: int) -> np.ndarray:
    """P x P int64: how many faces each node sends to each, where faces have been dealt in equal blocks.

    Parameters
    ----------
    faces
        Of each node those that it needs.
    count
        N faces.
    """
    nodes = len(faces.start) - 1
    owner = np.repeat(np.arange(nodes), np.diff(faces.start))
    moves = np.zeros((nodes, nodes), dtype=np.int64)
    np.add.at(moves, (faces.face * nodes // count, owner), 1)
    return moves


def split_ends(splitter: str, moves: np.ndarray, count: int, tallied: int, cube: Hypercube, timing: NodeTiming, *,
               shape: tuple[int, int]) -> np.ndarray:
    """When each node has the faces of its region: P int64.

    Nodes make boxes of the faces that they are dealt, count them, add the counts of all nodes over each channel, and
    cut. ``rs`` counts again for the columns of each band, and ``rrs`` at each level, at which each node sends boxes to
    a partner. Others add a mesh, and ``gs`` its edges too. Then faces are sent from each to all. The source has the
    steps, and no operations of them.

    Parameters
    ----------
    splitter
        A name of `SPLITTERS`.
    moves, count
        See `face_moves`.
    tallied
        Cells that all boxes meet, or 0 without a mesh.
    cube, timing
        The links, and a node.
    shape
        Lines and columns of the screen, or rows and columns of cells.

    Source: Kurc 1997, sections 6.1 and 6.4.
    """
    nodes, (lines, columns) = len(moves), shape
    levels, none = nodes.bit_length() - 1, np.zeros(nodes, dtype=np.int64)
    own = -(-count // nodes)

    def work(operations):
        return work_step(none + int(operations) * timing.operation)

    def summed(words):
        sums = reduction(nodes, words)
        sums.work[1:] = words * timing.operation
        return sums

    steps = [work(own * _BOX)]
    if splitter in ("hs", "rs"):
        steps += [work(own * _COUNTS), summed(2 * lines), work(_ENTRY * lines * (levels + 2))]
        if splitter == "rs":
            bands = 1 << (levels + 1) // 2
            steps += [work(own * _COUNTS), summed(2 * columns * bands), work(_ENTRY * columns * (levels + 2 * bands)),
                      concatenation(none + 2)]
    elif splitter == "rrs":
        steps.append(work(2 * own * _COUNTS))
        for level in range(levels):
            sums = summed(2 * (lines + columns))
            channels = levels - level
            # The nodes of a region alone add their counts; then half of a node's boxes go to its partner.
            sums = type(sums)(*(each[:channels] for each in sums))
            swap = reduction(nodes, own // 2 * _BOX_WORDS)
            swap = type(swap)(*(each[channels - 1:channels] for each in swap))
            steps += [sums, work(2 * _ENTRY * (lines + columns)), swap, work(own // 2 * 2 * _COUNTS)]
        steps.append(concatenation(none + 4))
    else:
        cells = lines * columns
        words = cells + (2 * lines * columns - lines - columns if splitter == "gs" else 0)
        each = {"mahd": 2 * _ENTRY, "hcs": _CURVE, "gs": _BISECTION * levels}[splitter]
        steps += [work(own * _CELLS + tallied // nodes * _CELL * (2 if splitter == "gs" else 1)), summed(words),
                  work(cells * each), work(own * _CELLS)]
    ends = run_program(joined(*steps), cube, none)
    return all_to_all_ends(FACE_WORDS * moves, cube, ends)
