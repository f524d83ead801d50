"""Solution programs: what the nodes do in an iteration of a solver, and before the first one."""

import numpy as np

from radiosity.machines.common.collectives import concatenation, reduction
from radiosity.machines.common.node_programs import Program, joined, work_step
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.gather.node_matrix import NodeMatrix

__all__ = ["iteration_program", "preparation_program", "renumbering_program"]

_OF_ENTRY = 2
"""Operations on an entry: a multiplication and an addition."""


def renumbering_program(matrix: NodeMatrix, timing: NodeTiming) -> Program:
    """The nodes' lists of patches become one, the table of its inverse, and then the column of each entry.

    The source counts no operations; ours are one for each element of the table and one for each entry.

    Source: Kurc 1997, section 2.5.3.
    """
    work = (matrix.matrix.shape[0] + matrix.entry_counts) * timing.operation
    return joined(concatenation(np.diff(matrix.rows)), work_step(work))


def preparation_program(solver: str, matrix: NodeMatrix, timing: NodeTiming) -> Program:
    """What precedes the first iteration of a channel.

    Gauss-Jacobi begins with the emissions. Merged, the first iteration has no exchange before it, so they are
    distributed here. Conjugate gradients scale the system: two square roots, a multiplication and two divisions for a
    row, and the residual's square.
    """
    if solver == "gauss-jacobi":
        return concatenation(np.diff(matrix.rows))
    return joined(work_step(7 * np.diff(matrix.rows) * timing.operation), reduction(matrix.nodes, 1))


def iteration_program(solver: str, matrix: NodeMatrix, timing: NodeTiming, *, completion: str = "merge") -> Program:
    """An iteration of a channel: 2 M + 6 N operations of Gauss-Jacobi, 2 M + 18 N of conjugate gradients.

    Without split rows its time in equal shares is that of Eqs. 2.15 and 2.16. To shift takes a message of a word and an
    addition. To merge takes a word and an addition for each exchange; conjugate gradients need two words, for the
    partial products of both ends of each group of nodes. The source describes that for Gauss-Jacobi alone.

    Parameters
    ----------
    solver
        A name of `PARALLEL_SOLVERS`.
    matrix
        The form factors.
    timing
        Operations and messages.
    completion
        A name of `COMPLETIONS`.

    Source: Kurc 1997, Figs. 2.7 and 2.9, Eqs. 2.7, 2.11, 2.15 and 2.16, section 2.6.
    """
    nodes, owned = matrix.nodes, np.diff(matrix.rows)
    parts = matrix.part_counts
    is_merged = bool(completion == "merge" and matrix.is_split.any())

    def work(each, rows, entries=0):
        return work_step((each * rows + entries) * timing.operation)

    product = _OF_ENTRY * matrix.entry_counts
    shifted = () if is_merged or not matrix.is_split.any() else (_shift(matrix, timing),)
    if solver == "gauss-jacobi":
        if is_merged:
            return joined(work(2, parts, product), _repairing(matrix, timing), work(4, owned), reduction(nodes, 2))
        return joined(concatenation(owned), work(0, owned, product), *shifted, work(6, owned), reduction(nodes, 2))
    total = reduction(nodes, 1)
    if is_merged:
        split = _boundaries(matrix)
        total = total._replace(words=total.words + 2 * split, work=total.work + split * timing.operation)
    return joined(work(1, owned), concatenation(owned), work(0, owned, product), *shifted,
                  work(4, parts if is_merged else owned), total, work(11, owned), reduction(nodes, 3), work(2, owned))


def _boundaries(matrix):
    """D x P int64: whether the two groups of nodes that exchange over a channel share a row."""
    nodes = np.arange(matrix.nodes)
    channel = np.arange(matrix.nodes.bit_length() - 1)[:, None]
    return matrix.is_split[(nodes >> channel + 1 << channel + 1) + (1 << channel)].astype(np.int64)


def _repairing(matrix, timing):
    """The concatenation of slices whose ends are parts, which the exchanges add."""
    split = _boundaries(matrix)
    exchanges, work = concatenation(matrix.part_counts, split), split * timing.operation
    # The first exchange has nothing to add before it, so each addition belongs to the step after its exchange.
    exchanges.work[1:] = work[:-1]
    return joined(exchanges, work_step(work[-1] if len(work) else np.zeros(matrix.nodes)))


def _shift(matrix, timing):
    """Each node that has the first part of a split row sends its product to the next one, which adds it."""
    step = work_step(np.zeros(matrix.nodes, dtype=np.int64))
    takers = np.flatnonzero(matrix.is_split)
    step.target[0, takers - 1], step.source[0, takers], step.words[0, takers - 1] = takers, takers - 1, 1
    return joined(step, work_step(matrix.is_split * timing.operation))
