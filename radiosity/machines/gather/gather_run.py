"""Gather run: form factors and radiosity of a scene on simulated nodes."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from golden.light.solvers import RadiositySystem
from radiosity.machines.common.assignment import check_nodes
from radiosity.machines.common.content_hash import content_hash
from radiosity.machines.common.hypercube import MESSAGES, WORDS, hypercube
from radiosity.machines.common.node_programs import run_program
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.common.nodes import spread_over_nodes
from radiosity.machines.gather.node_matrix import NodeMatrix, renumbered, restored
from radiosity.machines.gather.node_memory import NodeMemory
from radiosity.machines.gather.parallel_solvers import ChannelSolution, check_completion, solve_channel
from radiosity.machines.gather.projection_work import ProjectionWork
from radiosity.machines.gather.redistribution import moves_of, redistributed, redistribution_program
from radiosity.machines.gather.row_phase import GatherScheme, RowPhase, make_matrix_rows
from radiosity.machines.gather.solution_programs import iteration_program, preparation_program, renumbering_program

__all__ = ["GatherRun", "SolutionPhase", "simulate_gather", "solution_times"]

_OPERATIONS = {"gauss-jacobi": 6, "conjugate-gradient": 18}


@dataclass(frozen=True, kw_only=True, eq=False)
class SolutionPhase:
    """The times of a solution, in ns.

    Parameters
    ----------
    redistribution, renumbering
        ns of each; 0 without.
    iterations
        Iterations of all channels.
    solving
        ns of all iterations, with what precedes those of each channel.
    alone
        ns of the same iterations on one node.
    """

    redistribution: int
    renumbering: int
    iterations: int
    solving: int
    alone: int

    @property
    def time(self) -> int:
        """Ns of the phase."""
        return self.redistribution + self.renumbering + self.solving


@dataclass(frozen=True, kw_only=True, eq=False)
class GatherRun:
    """A scene's radiosity, made by simulated nodes.

    Parameters
    ----------
    scheme, solver
        How.
    memory
        A node's.
    rows, solution
        The two phases.
    factors
        N x N, in the scene's numbers: rows as the nodes have them, put together.
    matrix
        The rows in the nodes that solved.
    channels
        The solution of each channel.
    radiosity
        N x 3, in the scene's numbers.
    sent
        P x 2 int64: messages and words that each node has sent.
    """

    scheme: GatherScheme
    solver: str
    memory: NodeMemory
    rows: RowPhase
    solution: SolutionPhase
    factors: sparse.csr_array
    matrix: NodeMatrix
    channels: tuple[ChannelSolution, ...]
    radiosity: np.ndarray
    sent: np.ndarray

    def report(self) -> dict:
        """Times, traffic, memory and hashes, ready for JSON."""
        rows, solution, nodes = self.rows, self.solution, self.rows.assignment.nodes
        time = rows.time + solution.time
        busy = np.add.reduceat(rows.alone[rows.assignment.order], rows.assignment.bounds[:-1])
        return {
            "nodes": nodes, "scheme": self.scheme.name,
            "assignment": None if self.scheme.name == "demand-driven" else self.scheme.assignment,
            "solver": self.solver, "patches": len(rows.alone), "entries": int(self.matrix.entries[-1]),
            "seconds": time / 1e9, "efficiency": (int(rows.alone.sum()) + solution.alone) / (nodes * time),
            "form_factors": {"seconds": rows.time / 1e9, "alone_seconds": int(rows.alone.sum()) / 1e9,
                             "efficiency": rows.efficiency, "rows_before_full": rows.before_full},
            "solution": {"seconds": solution.time / 1e9, "alone_seconds": solution.alone / 1e9,
                         "efficiency": solution.alone / (nodes * solution.time),
                         "redistribution_seconds": solution.redistribution / 1e9,
                         "renumbering_seconds": solution.renumbering / 1e9,
                         "iterations": [one.iterations for one in self.channels],
                         "errors": [one.error for one in self.channels]},
            "traffic": {"messages": int(self.sent[:, MESSAGES].sum()), "words": int(self.sent[:, WORDS].sum()),
                        "circulated_words": rows.circulated_words},
            "memory": {"bytes": self.memory.size, "most_bytes": int(rows.peak_bytes.max())},
            "of_a_node": spread_over_nodes(
                rows=rows.assignment.sizes, row_milliseconds=busy // 1_000_000, entries=self.matrix.entry_counts,
                words_sent=self.sent[:nodes, WORDS], bytes=rows.peak_bytes),
            "F": content_hash(self.factors.indptr.astype(np.int64), self.factors.indices.astype(np.int64),
                              self.factors.data),
            "radiosity": content_hash(self.radiosity)}


def simulate_gather(system: RadiositySystem, work: ProjectionWork, scheme: GatherScheme, *, nodes: int,
                    solver: str = "gauss-jacobi", completion: str | None = None,
                    memory: NodeMemory | None = None) -> GatherRun:
    """Simulate both phases.

    Parameters
    ----------
    system
        The form factors, rows of golden's, and the patches' reflectances, emissions and areas.
    work
        The projections of the same scene, and the timing of a node.
    scheme
        Which node makes which row.
    nodes
        P, a power of two up to 1024.
    solver
        ``gauss-jacobi`` or ``conjugate-gradient``.
    completion
        How split rows are completed after the redistribution of entries, ``shift`` or ``merge``. Default: entries stay.
    memory
        Of a node. Default: the iPSC/2's.

    Raises
    ------
    InputError
        A name is none, the nodes are no hypercube, rows do not fit, or the solution is not reached.
    """
    check_nodes(nodes, len(system))
    timing, memory = work.timing, memory or NodeMemory()
    factors = sparse.csr_array(system.matrix)
    cube = hypercube(nodes, timing)
    rows = make_matrix_rows(scheme, np.diff(factors.indptr).astype(np.int64), work, cube, memory)
    order = rows.assignment.order
    before = NodeMatrix.of_rows(renumbered(factors, rows.assignment), rows.assignment.bounds)
    matrix = redistributed(before) if completion else before
    channels = tuple(solve_channel(
        solver, matrix, reflectance=system.reflectance[order, one], emission=system.emission[order, one],
        area=system.area[order], completion=completion or "merge") for one in range(3))
    solution = solution_times(before, matrix, solver, cube, timing, iterations=[one.iterations for one in channels],
                              completion=completion, is_renumbered=scheme.name == "demand-driven")
    radiosity = np.stack([one.radiosity for one in channels], axis=1)[rows.assignment.number]
    return GatherRun(scheme=scheme, solver=solver, memory=memory, rows=rows, solution=solution,
                     factors=restored(matrix.matrix, rows.assignment), matrix=matrix, channels=channels,
                     radiosity=radiosity, sent=cube.sent)


def solution_times(before: NodeMatrix, matrix: NodeMatrix, solver: str, cube, timing: NodeTiming, *,
                   iterations: list[int], completion: str | None = None, is_renumbered: bool = True) -> SolutionPhase:
    """The times of a solution whose iterations are known.

    Entries are redistributed first, so that renumbering is balanced too. The nodes begin each part together,
    on idle links.

    Parameters
    ----------
    before, matrix
        Rows where they were made, and where they are solved.
    solver, cube, timing
        See `simulate_gather`.
    iterations
        Of each channel.
    completion
        See `simulate_gather`.
    is_renumbered
        Whether the rows were made by request, so that columns have to be renumbered.

    Raises
    ------
    InputError
        The completion cannot complete a row.
    """
    check_completion(matrix, completion or "merge")

    def time(program, rounds=1):
        idle = cube._replace(free=np.zeros_like(cube.free))
        return int(run_program(program, idle, np.zeros(matrix.nodes, dtype=np.int64), rounds=rounds).max())

    moved = 0
    if completion:
        moved = time(redistribution_program(moves_of(before, matrix), matrix.nodes, timing))
    renumbering = time(renumbering_program(matrix, timing)) if is_renumbered else 0
    preparation = preparation_program(solver, matrix, timing)
    step = iteration_program(solver, matrix, timing, completion=completion or "merge")
    solving = sum(time(preparation) + time(step, rounds) for rounds in iterations)
    operations = 2 * int(matrix.entries[-1]) + _OPERATIONS[solver] * matrix.matrix.shape[0]
    return SolutionPhase(redistribution=moved, renumbering=renumbering, iterations=sum(iterations), solving=solving,
                         alone=sum(iterations) * operations * timing.operation)
