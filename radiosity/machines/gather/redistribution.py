"""Redistribution: entries of the matrix move between nodes until all have as many, but for one."""

from dataclasses import dataclass

import numpy as np

from radiosity.machines.common.assignment import shares
from radiosity.machines.common.collectives import concatenation
from radiosity.machines.common.node_programs import Program, joined, work_step
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.gather.node_matrix import NodeMatrix

__all__ = ["Moves", "moves_of", "redistributed", "redistribution_program"]

# Words of an entry and of a row's header: column and value; row and length.
_ENTRY_WORDS, _ROW_WORDS = 2, 2


@dataclass(frozen=True, kw_only=True, eq=False)
class Moves:
    """Messages of a redistribution, by source.

    Parameters
    ----------
    source, target
        Nodes of each message.
    entries, rows
        Its entries, and the whole and partial rows that they belong to.
    """

    source: np.ndarray
    target: np.ndarray
    entries: np.ndarray
    rows: np.ndarray


def redistributed(matrix: NodeMatrix) -> NodeMatrix:
    """The same entries in the same order: ceil(M / P) in each of the first M mod P nodes, floor(M / P) in the others.

    A row's element of a vector belongs to the last node that has entries of the row, that of a row without entries
    to the node of the entry that follows, or, behind all entries, to that of the last one. The last node has the rows
    of a matrix without entries.

    Source: Kurc 1997, section 2.6.1.
    """
    total, indptr = int(matrix.entries[-1]), matrix.matrix.indptr.astype(np.int64)
    entries = np.cumsum(np.append(0, shares(total, matrix.nodes)))
    last = np.minimum(np.maximum(indptr[1:] - 1, indptr[:-1]), max(total - 1, 0))
    owner = np.minimum(np.searchsorted(entries[1:], last, side="right"), matrix.nodes - 1)
    rows = np.searchsorted(owner, np.arange(matrix.nodes + 1))
    return NodeMatrix(matrix=matrix.matrix, entries=entries, rows=rows)


def moves_of(before: NodeMatrix, after: NodeMatrix) -> Moves:
    """What changes its node: the overlaps of the entries that one node has with those that another one will have."""
    bounds = np.unique(np.concatenate([before.entries, after.entries]))
    low, high = bounds[:-1], bounds[1:]
    source, target = (np.searchsorted(one.entries, low, side="right") - 1 for one in (before, after))
    moved, indptr = source != target, before.matrix.indptr
    row = [np.searchsorted(indptr, entry, side="right") for entry in (low, high - 1)]
    return Moves(source=source[moved], target=target[moved], entries=(high - low)[moved],
                 rows=(row[1] - row[0] + 1)[moved])


def redistribution_program(moves: Moves, nodes: int, timing: NodeTiming) -> Program:
    """All nodes get the counts of entries, add them up, and send what moves; one step for each distance of nodes.

    The source counts no operations; ours are additions of 2 P prefixes, and one for each word that is moved, at both
    nodes.

    Source: Kurc 1997, section 2.6.1.
    """
    prefix = work_step(np.full(nodes, 2 * nodes * timing.operation))
    words = _ENTRY_WORDS * moves.entries + _ROW_WORDS * moves.rows
    steps, taken = [concatenation(np.ones(nodes, dtype=np.int64)), prefix], np.zeros(nodes, dtype=np.int64)
    for distance in np.unique(moves.target - moves.source):
        chosen = moves.target - moves.source == distance
        source, target, sent = moves.source[chosen], moves.target[chosen], words[chosen]
        step = work_step(np.zeros(nodes, dtype=np.int64))
        step.target[0, source], step.source[0, target], step.words[0, source] = target, source, sent
        step.work[0, source] = sent * timing.operation
        steps.append(step)
        taken[target] += sent * timing.operation
    return joined(*steps, work_step(taken))
