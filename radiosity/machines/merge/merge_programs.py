"""Merge programs: what nodes do before pixels are merged, and the steps of the exchanges, in time."""

import numpy as np

from radiosity.machines.common.assignment import shares
from radiosity.machines.common.collectives import concatenation, reduction
from radiosity.machines.common.hypercube import Hypercube
from radiosity.machines.common.node_programs import Program, joined, run_program, work_step
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.merge.exchange_steps import ExchangeSteps, partners

__all__ = ["all_to_all_ends", "division_program", "exchange_program"]

_LINE_WORDS = _BOUND_WORDS = 2


def division_program(division: str, counts: np.ndarray, spans: np.ndarray, timing: NodeTiming, *, counting: int,
                     is_direct: bool) -> Program:
    """All nodes get the counts of all scanlines, and divide the screen.

    An exchange over each channel adds a count for each line. ``recursive`` then adds the counts up and searches them;
    where pixels go to owners directly, nodes exchange the bounds of their regions. ``packed`` counts spans before; each
    node sorts a share of the lines that have pixels, lists are merged over each channel, and a heap has two
    comparisons on each of its levels for each line. The source has the parts, and no operations of them.

    Parameters
    ----------
    division
        A name of `DIVISIONS`.
    counts
        H int64: pixels of each line, of all nodes.
    spans
        P int64: spans of each node.
    timing
        Of a node.
    counting
        Operations on a span that is counted.
    is_direct
        Whether the exchange is from each to all.

    Source: Kurc 1997, section 4.5.
    """
    nodes, height = len(spans), len(counts)
    none = np.zeros(nodes, dtype=np.int64)
    if division == "equal" or nodes == 1:
        return work_step(none)
    sums = reduction(nodes, height)
    sums.work[1:] = height * timing.operation
    if division == "recursive":
        bounds = concatenation(none + _BOUND_WORDS) if is_direct else work_step(none)
        return joined(sums, work_step(none + 3 * height * timing.operation), bounds)
    filled = int(np.count_nonzero(counts))
    own = shares(filled, nodes)
    levels = nodes.bit_length() - 1
    lists = concatenation(_LINE_WORDS * own)
    # What has come over a channel is merged before the next one.
    lists.work[1:] = 2 * lists.words[:-1] * timing.operation
    sorting = own * np.maximum(np.ceil(np.log2(np.maximum(own, 1))).astype(np.int64), 1)
    rest = 2 * filled + filled * 2 * levels + height
    return joined(work_step(spans * counting * timing.operation), sums,
                  work_step((height + sorting) * timing.operation), lists, work_step(none + rest * timing.operation))


def exchange_program(steps: ExchangeSteps, words: np.ndarray, merges: np.ndarray) -> Program:
    """The steps of an exchange on a mesh.

    Parameters
    ----------
    steps
        Who sends to whom.
    words, merges
        K x P int64: words that each node sends, and ns to merge what it receives.
    """
    before = np.concatenate([np.zeros_like(merges[:1]), merges[:-1]])
    program = Program(before, steps.target, steps.source, words)
    return joined(program, work_step(merges[-1])) if len(merges) else work_step(np.zeros_like(steps.region))


def all_to_all_ends(words: np.ndarray, cube: Hypercube, start: np.ndarray) -> np.ndarray:
    """When each node has the pixels of its region: an exchange with each other node, and a barrier after each.

    Parameters
    ----------
    words
        P x P int64: words from each node for each owner.
    cube
        The links.
    start
        P int64: when each node begins.

    Source: Kurc 1997, section 4.4.5, Eq. 4.18.
    """
    nodes = len(words)
    node, ends, barrier = np.arange(nodes), np.asarray(start, dtype=np.int64), reduction(nodes, 0)
    for step in range(1, nodes):
        other = partners(nodes, step)
        send = Program(np.zeros((1, nodes), dtype=np.int64), other[None], other[None], words[node, other][None])
        ends = run_program(joined(send, barrier), cube, ends)
    return ends
