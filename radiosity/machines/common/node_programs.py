"""Node programs: nodes that work and exchange messages step by step, each at its own pace."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.common.columns import columns
from radiosity.machines.common.event_heap import event_heap, next_time, pop, push
from radiosity.machines.common.hypercube import Hypercube, transfer

__all__ = ["Program", "joined", "run_program", "work_step"]

_READY, _ARRIVED = range(2)
# What a node is at, and whether it has sent.
_Node = columns("_Node", "STEP ROUND WAITS")
_NONE = -1


class Program(NamedTuple):
    """K steps of P nodes: a node works, then sends a message, then waits for one of the same step.

    Parameters
    ----------
    work
        K x P int64: ns of work.
    target, source
        K x P int64: the nodes to which a message goes and from which one comes, or -1.
    words
        K x P int64: words of the message that is sent.
    """

    work: np.ndarray
    target: np.ndarray
    source: np.ndarray
    words: np.ndarray


def work_step(work: np.ndarray) -> Program:
    """One step of work, P int64, without messages."""
    work = np.asarray(work, dtype=np.int64)[None]
    return Program(work, np.full_like(work, _NONE), np.full_like(work, _NONE), np.zeros_like(work))


def joined(*programs: Program) -> Program:
    """The steps of programs, one after the other."""
    return Program(*map(np.concatenate, zip(*programs, strict=True)))


def run_program(program: Program, cube: Hypercube, start: np.ndarray, *, rounds: int = 1) -> np.ndarray:
    """When each node ends its program.

    To set a message up takes the sending node's time; the transfer does not. A message that comes early waits in
    the memory of its target.

    Parameters
    ----------
    program, cube
        What the nodes do, and the links.
    start
        P int64: when each node begins.
    rounds
        How often they do it.

    Raises
    ------
    ValueError
        A message is sent to a node that does not expect it from its sender.
    """
    steps, nodes = program.work.shape
    sender, step = np.arange(nodes), np.arange(steps)[:, None]
    if (np.where(program.target >= 0, program.source[step, program.target], sender) != sender).any() or (
            np.where(program.source >= 0, program.target[step, program.source], sender) != sender).any():
        raise ValueError("Targets must be nodes that expect a message from the sender")
    if not steps or not rounds:
        return np.array(start, dtype=np.int64)
    ends, state = np.zeros(nodes, dtype=np.int64), np.zeros((nodes, len(_Node)), dtype=np.int64)
    heap = event_heap(nodes * (2 * steps + 1))
    _run(heap, program, cube, np.asarray(start, dtype=np.int64), rounds, state,
         np.zeros((steps, nodes), dtype=np.int64), ends)
    return ends


@compiled
def _begin(heap, program, cube, step, node, time):
    """The node works, and sets its message up."""
    ready = time + program.work[step, node]
    if program.target[step, node] != _NONE:
        ready += cube.setup
    push(heap, ready, _READY, node)


@compiled
def _run(heap, program, cube, start, rounds, state, arrived, ends):
    """All events. ``arrived`` counts the messages of each step that a node has not taken yet."""
    steps, nodes = program.work.shape
    for node in range(nodes):
        _begin(heap, program, cube, 0, node, start[node])
    while next_time(heap) != _NONE:
        time, kind, subject = pop(heap)
        node = subject % nodes
        if kind == _ARRIVED:
            arrived[subject // nodes, node] += 1
        else:
            step = state[node, _Node.STEP]
            state[node, _Node.WAITS] = 1
            target = program.target[step, node]
            if target != _NONE:
                end = transfer(cube, time, node, target, program.words[step, node])
                push(heap, end, _ARRIVED, target + nodes * step)
        step = state[node, _Node.STEP]
        expects = program.source[step, node] != _NONE
        if not state[node, _Node.WAITS] or (expects and arrived[step, node] == 0):
            continue
        if expects:
            arrived[step, node] -= 1
        state[node, _Node.WAITS] = 0
        step += 1
        if step == steps:
            step = 0
            state[node, _Node.ROUND] += 1
        state[node, _Node.STEP] = step
        if state[node, _Node.ROUND] == rounds:
            ends[node] = time
        else:
            _begin(heap, program, cube, step, node, time)
