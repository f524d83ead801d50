"""Row phase: the form factor rows of a scene, made by the nodes under one scheme."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError, check_choice, check_int
from radiosity.machines.common.assignment import ASSIGNMENTS, Assignment, assign, of_rows
from radiosity.machines.common.collectives import reduction
from radiosity.machines.common.hypercube import WORDS, Hypercube
from radiosity.machines.common.node_programs import run_program
from radiosity.machines.gather.circulation import circulate
from radiosity.machines.gather.demand_driven import demand_rows
from radiosity.machines.gather.node_memory import NodeMemory
from radiosity.machines.gather.projection_work import ProjectionWork
from radiosity.machines.gather.storage_sharing import make_rows

__all__ = ["SCHEMES", "GatherScheme", "RowPhase", "make_matrix_rows"]

SCHEMES = ("circulation", "sharing", "demand-driven")


@dataclass(frozen=True, kw_only=True)
class GatherScheme:
    """How rows are divided among the nodes, and where patches are.

    Parameters
    ----------
    name
        A name of `SCHEMES`.
    assignment
        A name of `ASSIGNMENTS`; the scheme demand-driven has none.
    granularity
        Patches of a request of the scheme demand-driven, at least 1.
    seed
        Seed of the assignment random.

    Raises
    ------
    TypeError
        A number is no int.
    InputError
        A name is none, or a number out of range.
    """

    name: str = "demand-driven"
    assignment: str = "random"
    granularity: int = 1
    seed: int = 0

    def __post_init__(self):
        for label, value, known in (("Scheme", self.name, SCHEMES), ("Assignment", self.assignment, ASSIGNMENTS)):
            check_choice(f"gather: {label}", value, known, parameter=label)
        for label, value, least in (("Granularity", self.granularity, 1), ("Seed", self.seed, 0)):
            check_int(label, value)
            if value < least:
                raise InputError(f"gather: {label} must be at least {least}, not {value!r}", parameter=label)


@dataclass(frozen=True, kw_only=True, eq=False)
class RowPhase:
    """Rows that have been made.

    Parameters
    ----------
    assignment
        Where each row is, in the order in which its node made them.
    ends
        P int64: ns in which each node ends.
    stored
        N int64: ns in which each patch's row is stored in its node.
    alone
        N int64: ns of each patch's row on a node that has all patches.
    before_full
        Rows that were stored before a memory was full or, of the scheme circulation, 0.
    circulated_words
        Words of patches that travelled.
    peak_bytes
        P int64: the most bytes that each node has taken.
    """

    assignment: Assignment
    ends: np.ndarray
    stored: np.ndarray
    alone: np.ndarray
    before_full: int
    circulated_words: int
    peak_bytes: np.ndarray

    @property
    def time(self) -> int:
        """Ns of the phase."""
        return int(self.ends.max())

    @property
    def efficiency(self) -> float:
        """Time of one node with enough memory over P times that of P nodes."""
        return int(self.alone.sum()) / (self.assignment.nodes * self.time)


def make_matrix_rows(scheme: GatherScheme, entries: np.ndarray, work: ProjectionWork, cube: Hypercube,
                     memory: NodeMemory) -> RowPhase:
    """Simulate the phase of form factors; the nodes begin at 0, with the patches that the scheme gives them.

    Where patches of the scheme demand-driven have to circulate, the source does not say which node holds which. Ours
    hold those of the assignment tiled, and the host deals what is left in turn.

    Parameters
    ----------
    scheme
        Which node makes which row.
    entries
        N int64: entries of each patch's row.
    work, cube, memory
        Projections, links and nodes.

    Raises
    ------
    InputError
        The nodes are no hypercube or more than the patches, or the rows of a node do not fit.

    Source: Kurc 1997, section 2.4.
    """
    count, nodes = len(entries), len(cube.free) - 1
    is_demanded = scheme.name == "demand-driven"
    held = assign("tiled" if is_demanded else scheme.assignment, count, nodes, seed=scheme.seed)
    alone, sizes, start = work.of_rows, memory.row_bytes(np.asarray(entries)), np.zeros(nodes, dtype=np.int64)
    stored = np.zeros(count, dtype=np.int64)
    if scheme.name == "circulation":
        rows, remaining, ends, is_full = [held.patches(node)[:0] for node in range(nodes)], None, start, True
    else:
        free = np.full(nodes, memory.free(count))
        if is_demanded:
            demanded = demand_rows(alone, sizes, free, cube, start, granularity=scheme.granularity)
            rows, stored, ends, is_full = _made(demanded, nodes), demanded.ended, demanded.ends, demanded.is_full
        else:
            shared = make_rows(alone[held.order], sizes[held.order], held.bounds, free, cube, start)
            rows = [held.patches(node)[:made] for node, made in enumerate(shared.stored)]
            stored[held.order] = shared.ended
            # All nodes get the number of rounds, which is 0 if no memory is full.
            ends, is_full = run_program(reduction(nodes, 1), cube, shared.ends), shared.is_full
    before = sum(map(len, rows))
    sent = int(cube.sent[:, WORDS].sum())
    peak = np.array([memory.size - memory.free(count) + sizes[made].sum() for made in rows]) if before else start
    if is_full:
        remaining = _remaining(rows, held, is_demanded)
        circulated = circulate(remaining, held, work, cube, ends)
        ends, stored = circulated.ends, np.maximum(stored, circulated.ended)
        rows = [np.concatenate(pair) for pair in zip(rows, remaining, strict=True)]
        # A node has its own patches, and a block that travels.
        own = held.sizes + (held.sizes.max() if nodes > 1 else 0)
        after = np.array([memory.size - memory.free(int(patches)) + sizes[made].sum()
                          for patches, made in zip(own, rows, strict=True)])
        if (after > memory.size).any():
            raise InputError(f"gather: Memory must be at least {after.max()} bytes for the patches and rows of node "
                             f"{after.argmax()}, not {memory.size}", parameter="memory")
        peak = np.maximum(peak, after)
    return RowPhase(assignment=of_rows(rows), ends=ends, stored=stored, alone=alone,
                    before_full=before, circulated_words=int(cube.sent[:, WORDS].sum()) - sent, peak_bytes=peak)


def _made(found, nodes):
    """Rows of each node in the order in which it made them by request."""
    order = np.argsort(found.ended, kind="stable")
    return [order[found.node[order] == node] for node in range(nodes)]


def _remaining(rows, held, is_dealt):
    """The patches of each node whose rows have not been stored."""
    if not is_dealt:
        return [held.patches(node)[len(made):] for node, made in enumerate(rows)]
    left = np.setdiff1d(np.arange(len(held.order)), np.concatenate(rows))
    return [left[node::held.nodes] for node in range(held.nodes)]
