"""Gathering solvers: each patch sums the light from all others."""

from collections.abc import Iterator

import numpy as np
from scipy import sparse

from golden.light.solvers.iteration import TOLERANCE, Solution, State, iterate
from golden.light.solvers.system import RadiositySystem

__all__ = ["SWEEPS", "gauss_jacobi", "gauss_seidel", "over_relaxation", "relaxed_sweeps"]

# Default of the most sweeps over all patches.
SWEEPS = 1000

# Patches relaxed together by one product and one small triangular inverse.
_BLOCK = 64


def gauss_jacobi(system: RadiositySystem, *, tolerance: float = TOLERANCE, max_steps: int = SWEEPS,
                 progress: bool = False) -> Solution:
    """Every patch gathers at once: b <- e + rho F b.

    Source: Kurc 1997, section 2.3.
    """
    return iterate(_jacobi_sweeps(system), tolerance=tolerance, max_steps=max_steps, progress=progress)


def gauss_seidel(system: RadiositySystem, *, tolerance: float = TOLERANCE, max_steps: int = SWEEPS,
                 progress: bool = False) -> Solution:
    """As `gauss_jacobi`, but each patch gathers the updated radiosities of the patches before it.

    Source: Shen 1993, Eq. 2.11.
    """
    return over_relaxation(system, omega=1.0, tolerance=tolerance, max_steps=max_steps, progress=progress)


def over_relaxation(system: RadiositySystem, *, omega: float = 1.2, tolerance: float = TOLERANCE,
                    max_steps: int = SWEEPS, progress: bool = False) -> Solution:
    """As `gauss_seidel`, but each patch moves ``omega`` times as far.

    Parameters
    ----------
    omega
        Above 0 and below 2; radiosity gains from about 1.2.

    Source: Shen 1993, Eq. 2.13.
    """
    return iterate(relaxed_sweeps(system, omega, system.emission.copy()), tolerance=tolerance, max_steps=max_steps,
                   progress=progress)


def _jacobi_sweeps(system: RadiositySystem) -> Iterator[State]:
    radiosity = system.emission.copy()
    while True:
        residual = system.residual(radiosity)
        yield State(radiosity, residual)
        radiosity = radiosity + residual


def relaxed_sweeps(system: RadiositySystem, omega: float, radiosity: np.ndarray) -> Iterator[State]:
    """States of successive over-relaxation from ``radiosity`` on, patch after patch in the order of their numbers.

    A block of patches gathers from outside it in one product; the inverse of its lower triangle gives the same values
    as relaxing its patches one by one.
    """
    yield State(radiosity, system.residual(radiosity))
    blocks = [_block(system, omega, slice(first, first + _BLOCK)) for first in range(0, len(system), _BLOCK)]
    while True:
        for rows, factors, below, inverse in blocks:
            old, rho = radiosity[rows], system.reflectance[rows]
            outside = system.emission[rows] + rho * (factors @ radiosity - below @ old)
            target = (1 - omega) * old + omega * outside
            radiosity[rows] = (inverse @ target.T[:, :, None])[:, :, 0].T
        yield State(radiosity, system.residual(radiosity))


def _block(system, omega, rows):
    """Rows of the matrix, their own strict lower triangle, and (1 - omega rho L)^-1 of each channel."""
    factors = system.matrix[rows]
    own = factors[:, rows]
    below = np.tril(own.toarray() if sparse.issparse(own) else own, -1)
    identity = np.eye(len(below))
    return rows, factors, below, np.linalg.inv(identity - omega * system.reflectance[rows].T[:, :, None] * below)
