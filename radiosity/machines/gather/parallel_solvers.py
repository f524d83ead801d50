"""Parallel solvers: Gauss-Jacobi and scaled conjugate gradients on rows that the nodes have."""

from dataclasses import dataclass
from functools import partial
from math import fsum

import numpy as np

from golden.base.errors import InputError, check_choice
from golden.light.solvers import TOLERANCE
from radiosity.machines.gather.node_matrix import NodeMatrix

__all__ = ["COMPLETIONS", "PARALLEL_SOLVERS", "ChannelSolution", "check_completion", "solve_channel"]

COMPLETIONS = ("shift", "merge")
"""How split rows are completed: a message to the next node, or with the exchanges that an iteration has anyway."""

# Black patches count as nearly black: the scaled system has none.
_BLACK = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class ChannelSolution:
    """The radiosity of one colour channel.

    Parameters
    ----------
    radiosity
        N, in the nodes' numbers.
    iterations
        Iterations.
    error
        Sum of the absolute residuals over the largest radiosity, at the end.
    """

    radiosity: np.ndarray
    iterations: int
    error: float


def check_completion(matrix: NodeMatrix, completion: str) -> None:
    """A name is one of `COMPLETIONS` and can complete the split rows of the matrix.

    Raises
    ------
    InputError
        It is none, or a row is shared by more than two nodes: a message to the next node then misses some.
    """
    check_choice("gather: Completion", completion, COMPLETIONS, parameter="completion")
    if completion == "shift" and matrix.sharers > 2:
        raise InputError(f"gather: Completion must be merge for a row that {matrix.sharers} nodes share, not 'shift'",
                         parameter="completion")


def solve_channel(solver: str, matrix: NodeMatrix, *, reflectance: np.ndarray, emission: np.ndarray, area: np.ndarray,
                  completion: str = "merge", tolerance: float = TOLERANCE, most: int = 1000) -> ChannelSolution:
    """Solve b = e + rho F b for one channel.

    Sums over all patches are rounded once, so they depend neither on the number of nodes nor on the patches' order.
    The source adds the nodes' rounded sums.

    Parameters
    ----------
    solver
        A name of `PARALLEL_SOLVERS`.
    matrix
        The form factors.
    reflectance, emission, area
        N each, in the nodes' numbers.
    completion
        A name of `COMPLETIONS`.
    tolerance, most
        The error to reach, and the most iterations until then.

    Raises
    ------
    InputError
        No solver or completion has that name, the completion cannot complete a row, or the error is not reached.

    Source: Kurc 1997, sections 2.5.1, 2.5.2 and 2.6; Eq. 2.12 for the error.
    """
    check_choice("gather: Solver", solver, PARALLEL_SOLVERS)
    check_completion(matrix, completion)
    states = PARALLEL_SOLVERS[solver](partial(_affine, matrix, completion), reflectance, emission, area)
    for iteration in range(1, most + 1):
        radiosity, residual = next(states)
        error = _error(radiosity, residual)
        if error < tolerance:
            return ChannelSolution(radiosity=radiosity, iterations=iteration, error=error)
    raise InputError(f"gather: Iterations must be more than {most} for an error below {tolerance!r}, not {most}")


def _error(radiosity, residual):
    total, largest = fsum(np.abs(residual).tolist()), np.abs(radiosity).max()
    return total / largest if largest else total and np.inf


def _affine(matrix, completion, vector, factor, addend):
    """``addend`` + ``factor`` * (F vector), whose split rows are completed before or after what is linear in them."""
    partials = matrix.partial_products(vector)
    if completion == "shift":
        return addend + factor * matrix.completed(partials)
    # The owner of a split row alone adds what is no part of the product.
    row = matrix.part_row
    return matrix.completed(np.where(matrix.is_owner, addend[row], 0.0) + factor[row] * partials)


def _gauss_jacobi(affine, reflectance, emission, area):
    radiosity = emission.copy()
    while True:
        following = affine(radiosity, reflectance, emission)
        yield radiosity, following - radiosity
        radiosity = following


def _conjugate_gradient(affine, reflectance, emission, area):
    reflectance = np.maximum(reflectance, _BLACK)
    before, after = np.sqrt(reflectance * area), np.sqrt(reflectance / area)
    scaled, residual = np.zeros_like(emission), emission / after
    direction, square = residual, _dot(residual, residual)
    while True:
        image = affine(after * direction, -before, direction)
        along = _dot(direction, image)
        step = square / along if along else 0.0
        scaled, residual = scaled + step * direction, residual - step * image
        yield after * scaled, after * residual
        square, previous = _dot(residual, residual), square
        direction = residual + (square / previous if previous else 0.0) * direction


def _dot(one, other):
    return fsum((one * other).tolist())


PARALLEL_SOLVERS = {"gauss-jacobi": _gauss_jacobi, "conjugate-gradient": _conjugate_gradient}
