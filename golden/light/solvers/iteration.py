"""Common part of all solvers: a sequence of states, its end, and its result."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice

import numpy as np

from golden.base.progress_bar import progress_bar

__all__ = ["TOLERANCE", "Solution", "State", "iterate"]

# Below about 1e-7 single precision, in which images are made, gains nothing more.
TOLERANCE = 5e-6


@dataclass(frozen=True, eq=False)
class State:
    """A solver's state after a step, N x 3 each.

    ``residual`` is e + rho F b - b (for a shooting solver the unshot radiosity), ``ambient`` an estimate of the light
    that is still missing.
    """

    radiosity: np.ndarray
    residual: np.ndarray
    ambient: np.ndarray | float = 0.0


@dataclass(frozen=True, kw_only=True, eq=False)
class Solution:
    """Result of a solver.

    Parameters
    ----------
    radiosity
        N x 3.
    ambient
        N x 3, an estimate of the light that is still missing: zero for gathering solvers.
    steps
        Steps: sweeps over all patches of a gathering solver, shots of a shooting one.
    errors
        ``steps`` x 3: of each channel after each step the sum of the absolute residuals over the largest radiosity, or
        the solver's own measure.
    converged
        Whether the last errors are all below the tolerance.
    """

    radiosity: np.ndarray
    ambient: np.ndarray
    steps: int
    errors: np.ndarray
    converged: bool

    @property
    def display(self) -> np.ndarray:
        """N x 3: the best estimate for a picture of a solution that was stopped early."""
        return self.radiosity + self.ambient


def error_of(state: State) -> np.ndarray:
    """Sum of the absolute residuals over the largest radiosity, 3 channels; 0 for a dark channel.

    Source: Kurc 1997, Eq. 2.12.
    """
    residual, largest = np.abs(state.residual).sum(axis=0), np.abs(state.radiosity).max(axis=0)
    return np.divide(residual, largest, out=np.where(residual > 0, np.inf, 0.0), where=largest > 0)


def iterate(states: Iterator[State], *, tolerance: float, max_steps: int, progress: bool = False,
            error: Callable[[State], np.ndarray] = error_of) -> Solution:
    """Draw states until every channel's error is below ``tolerance``, ``max_steps`` at most.

    Parameters
    ----------
    states
        The solver's states.
    tolerance, max_steps
        Above 0, and at least 1.
    progress
        Shows a progress bar after two seconds.
    error
        Function from a state to the errors of the three channels.
    """
    errors = []
    with progress_bar(desc="radiosity", unit="step", delay=2, disable=not progress) as bar:
        for state in islice(states, max_steps):
            errors.append(error(state))
            bar.update()
            if (errors[-1] < tolerance).all():
                break
    return Solution(radiosity=state.radiosity.copy(), ambient=np.zeros_like(state.radiosity) + state.ambient,
                    steps=len(errors), errors=np.array(errors), converged=bool((errors[-1] < tolerance).all()))
