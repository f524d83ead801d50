"""The scaled conjugate gradient method."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from golden.light.solvers.gathering import SWEEPS, relaxed_sweeps
from golden.light.solvers.iteration import TOLERANCE, Solution, State, iterate
from golden.light.solvers.system import RadiositySystem

__all__ = ["conjugate_gradient"]

# Reciprocity makes the system symmetric once it is divided by the reflectances; black patches count as nearly black.
_BLACK = 1e-6

# A symmetric system with a mean reflectance of 0.99 takes a third of this.
_MAX_STEPS = 300


def conjugate_gradient(system: RadiositySystem, *, tolerance: float = TOLERANCE, max_steps: int = SWEEPS,
                       progress: bool = False) -> Solution:
    """Conjugate gradients on the system scaled to be symmetric with a unit diagonal, which is never formed.

    Cast form factors obey reciprocity only approximately, and black patches count as nearly black. So the residual is
    recomputed at the end. If it is not below ``tolerance``, or does not fall, Gauss-Seidel sweeps follow; their steps
    are counted too.

    Source: Kurc 1997, sections 2.4 and 2.5.
    """
    found = iterate(_descents(system), tolerance=tolerance, max_steps=min(max_steps, _MAX_STEPS), progress=progress)
    start = found.radiosity.copy() if found.converged else system.emission.copy()
    polished = iterate(relaxed_sweeps(system, 1.0, start), tolerance=tolerance,
                       max_steps=max(1, max_steps - found.steps), progress=progress)
    if polished.steps == 1 and polished.converged == found.converged:
        return found
    errors = np.concatenate([found.errors, polished.errors])
    return replace(polished, errors=errors, steps=len(errors))


def _descents(system: RadiositySystem) -> Iterator[State]:
    reflectance, area = np.maximum(system.reflectance, _BLACK), system.area[:, None]
    before, after = np.sqrt(reflectance * area), np.sqrt(reflectance / area)
    scaled = np.zeros_like(reflectance)
    residual = system.emission / after
    direction = residual
    square = (residual**2).sum(axis=0)
    while True:
        image = direction - before * (system.matrix @ (after * direction))
        step = _ratio(square, np.maximum((direction * image).sum(axis=0), 0.0))
        scaled = scaled + step * direction
        residual = residual - step * image
        yield State(after * scaled, after * residual)
        square, previous = (residual**2).sum(axis=0), square
        direction = residual + _ratio(square, previous) * direction


def _ratio(a, b):
    """Quotient a / b; 0 where b is 0: the channel has converged."""
    return np.divide(a, b, out=np.zeros_like(a), where=b != 0)
