"""Shooting solvers: the patches with most unshot light distribute it, so that early results are useful.

Rows of form factors are computed when their patches shoot.
"""

from collections.abc import Iterator
from itertools import count

import numpy as np

from golden.light.solvers.iteration import TOLERANCE, Solution, State, iterate
from golden.light.solvers.system import RadiositySystem

__all__ = ["ambient_overshooting", "progressive_refinement", "proximity_refinement", "shots"]

# Default of the most shots per patch, on average.
_SHOTS = 1000

# Patches shoot together if their normals are within 30 degrees and each has this share of the brightest one's light.
_SIMILAR = np.cos(np.radians(30.0))
_BRIGHT = 0.5


def progressive_refinement(system: RadiositySystem, *, tolerance: float = TOLERANCE, max_steps: int | None = None,
                           progress: bool = False) -> Solution:
    """Shoot the unshot radiosity of the patch that has most of it (times its area).

    Source: Shen 1993, Eq. 2.12; Cohen et al. 1988.
    """
    return _refine(system, shots(system), tolerance=tolerance, max_steps=max_steps, progress=progress)


def ambient_overshooting(system: RadiositySystem, *, tolerance: float = TOLERANCE, max_steps: int | None = None,
                         progress: bool = False) -> Solution:
    """As `progressive_refinement`, but also shoot the patch's expected gain from the ambient light.

    Where that was too much, the unshot radiosity is negative and is shot later.

    Source: Shen 1993, section 2.2.2.3; Feda and Purgathofer 1992.
    """
    return _refine(system, shots(system, overshoot=1.0), tolerance=tolerance, max_steps=max_steps, progress=progress)


def proximity_refinement(system: RadiositySystem, *, group: int = 8, tolerance: float = TOLERANCE,
                         max_steps: int | None = None, progress: bool = False) -> Solution:
    """As `progressive_refinement`, but up to ``group`` near bright patches with similar normals shoot at once.

    They see nearly the same half-space, so their castings share the scene data.

    Source: Shen 1993, section 2.5.
    """
    return _refine(system, shots(system, group=group), tolerance=tolerance, max_steps=max_steps, progress=progress)


def shots(system: RadiositySystem, *, group: int = 1, overshoot: float = 0.0) -> Iterator[State]:
    """The states before each step of shooting.

    Parameters
    ----------
    system
        The system; of more shooters than one in a step with centres and normals.
    group
        Patches that shoot in a step, at most: the brightest one, and those near it with similar normals.
    overshoot
        Share of a patch's expected gain from the ambient light that it shoots too.
    """
    energy, shares = _Energy(system), system.area / system.area.sum()
    # Some light is absorbed even where all patches are white: the series is cut at a hundred reflections.
    reflections = 1.0 / np.maximum(1.0 - shares @ system.reflectance, 0.01)
    shot, unshot = np.zeros_like(system.emission), system.emission.copy()
    before = np.inf
    for step in count():
        ambient = system.reflectance * np.maximum(reflections * (shares @ unshot), 0.0)
        yield State(shot + unshot, unshot, ambient)
        if overshoot and step % len(system) == 0:
            # Overshooting may cycle: then it is damped to plain shooting.
            left = energy(unshot).sum()
            overshoot, before = overshoot if left < before else overshoot / 2, left
        amounts = unshot + overshoot * ambient
        patches = energy.brightest(amounts, group)
        amounts = amounts[patches]
        shot[patches] += amounts
        unshot[patches] -= amounts
        unshot += system.reflectance * (system.columns(patches) @ amounts)


class _Energy:
    """Energy of amounts to shoot, with channels weighted by the scene's emission."""

    def __init__(self, system):
        emitted = (system.area[:, None] * system.emission).sum(axis=0)
        self._weight = system.area[:, None] * np.divide(1.0, emitted, out=np.zeros(3), where=emitted > 0)
        self._centre, self._normal = system.centre, system.normal

    def __call__(self, amounts):
        return (self._weight * np.abs(amounts)).sum(axis=1)

    def brightest(self, amounts, group):
        """The brightest patch, and so many of its bright neighbours that there are ``group`` in all, at most."""
        share = self(amounts)
        first = int(share.argmax())
        if group == 1:
            return np.array([first])
        fit = (self._normal @ self._normal[first] >= _SIMILAR) & (share >= _BRIGHT * share[first]) & (share > 0)
        near = np.flatnonzero(fit)
        distance = ((self._centre[near] - self._centre[first]) ** 2).sum(axis=1)
        return near[np.argsort(distance, kind="stable")[:group]]


def _refine(system, states, *, tolerance, max_steps, progress) -> Solution:
    return iterate(states, tolerance=tolerance, max_steps=_SHOTS * len(system) if max_steps is None else max_steps,
                   progress=progress)
