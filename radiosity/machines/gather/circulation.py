"""Patch circulation: patches travel around a ring of the nodes, so that each node stores its own ones alone."""

from typing import NamedTuple

import numpy as np

from radiosity.machines.common.assignment import Assignment
from radiosity.machines.common.hypercube import Hypercube, ring
from radiosity.machines.common.node_programs import Program, run_program
from radiosity.machines.gather.node_memory import PATCH_WORDS
from radiosity.machines.gather.projection_work import ProjectionWork

__all__ = ["CirculatedRows", "circulate"]


class CirculatedRows(NamedTuple):
    """Rows that nodes made while patches travelled.

    Parameters
    ----------
    ended
        N int64: when each patch's row was stored; 0 of rows that are not made here.
    ends
        P int64: when each node has its rows and has sent all blocks on.
    """

    ended: np.ndarray
    ends: np.ndarray


def circulate(rows: list[np.ndarray], held: Assignment, work: ProjectionWork, cube: Hypercube,
              start: np.ndarray) -> CirculatedRows:
    """Make rows while blocks of patches travel around a ring; times are in ns.

    A node projects its own patches on the hemicube of a row. It sends them to the node on its left, takes a block from
    the node on its right, projects it and sends it on, until all blocks have come. A node without a further row only
    sends blocks on, for the others. A block that comes early waits in the memory of its target. A node sends a copy,
    and copies what it takes; the source has no times of copies, ours take an operation for each word.

    Parameters
    ----------
    rows
        Of each node the patches whose rows it makes, in that order.
    held
        The patches that each node holds.
    work, cube
        The projections, and the links.
    start
        P int64: when each node begins.

    Source: Kurc 1997, section 2.4.1, Fig. 2.5.
    """
    nodes = held.nodes
    block = np.empty(len(held.order), dtype=np.int64)
    block[held.order] = np.repeat(np.arange(nodes), held.sizes)
    projections, around = work.of_blocks(block, nodes), ring(nodes)
    position = np.argsort(around)
    # The block that is at each node in each step, and the step's neighbours.
    at = around[(position + np.arange(nodes)[:, None]) % nodes]
    left, right = around[position - 1], around[(position + 1) % nodes]
    is_sent = np.arange(nodes)[:, None] < nodes - 1
    target, source = np.where(is_sent, left, -1), np.where(is_sent, right, -1)
    words = np.where(is_sent, PATCH_WORDS * held.sizes[at], 0)
    copied = (words + np.append(np.zeros_like(words[:1]), words[:-1][:, right], axis=0)) * work.timing.operation
    ends, ended = np.array(start, dtype=np.int64), np.zeros(len(held.order), dtype=np.int64)
    for turn in range(max(map(len, rows))):
        steps = copied.copy()
        made = np.array([node for node, each in enumerate(rows) if turn < len(each)])
        patches = np.array([rows[node][turn] for node in made])
        steps[:, made] += projections[patches, at[:, made]]
        steps[0, made] += work.clearing
        steps[-1, made] += work.summing
        ends = run_program(Program(steps, target, source, words), cube, ends)
        ended[patches] = ends[made]
    return CirculatedRows(ended=ended, ends=ends)
