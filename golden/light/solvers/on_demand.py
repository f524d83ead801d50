"""Radiosity as the thesis runs it: shooters are chosen, their rows are cast, and the rest waits."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from numbers import Real

import numpy as np

from golden.base.errors import InputError, whole_number
from golden.light.solvers.iteration import Solution, State, iterate
from golden.light.solvers.shooting import shots
from golden.light.solvers.system import RadiositySystem

__all__ = ["Shooting", "shoot"]

# The most shots of a patch, on average.
_SHOTS = 100
# Share of its expected gain that a patch shoots in advance: all of it makes darker patches shoot too early.
_OVERSHOOT = 0.5


@dataclass(frozen=True, kw_only=True)
class Shooting:
    """How shooters are chosen, and when shooting ends.

    Parameters
    ----------
    tolerance
        Ends when the light that is still missing is estimated to be at most this share of the radiosities, as
        area-weighted roots of mean squares: 1e-6 to 0.5.
    shooters
        Patches that shoot in a step, at most, 1 to 4096: the one with the most unshot power, and those near it with
        similar normals. Their hemispheres are cast together.
    overshoot
        Whether a patch also shoots half of what it is expected to gain from the ambient light.

    Raises
    ------
    InputError
        A value is out of range.
    """

    tolerance: float = 0.01
    shooters: int = 8
    overshoot: bool = True

    def __post_init__(self):
        value = self.tolerance
        if isinstance(value, bool) or not isinstance(value, Real) or not 1e-6 <= value <= 0.5:
            raise InputError(f"shooting: Tolerance must be 1e-6 to 0.5, not {value!r}", parameter="tolerance")
        whole_number("shooting: Shooters", self.shooters, 1, 4096, parameter="shooters")
        if not isinstance(self.overshoot, bool):
            raise InputError(f"shooting: Overshoot must be true or false, not {self.overshoot!r}",
                             parameter="overshoot")

    def states(self, system: RadiositySystem) -> Iterator[State]:
        """The states before each step."""
        return shots(system, group=self.shooters, overshoot=_OVERSHOOT * self.overshoot)


def shoot(system: RadiositySystem, shooting: Shooting, *, watch: Callable[[State], None] | None = None,
          progress: bool = False) -> Solution:
    """Solve a system whose rows are cast when their patches shoot.

    Parameters
    ----------
    system
        The system; rows on demand.
    shooting
        How shooters are chosen, and when shooting ends.
    watch
        Is called with the state before each step.
    progress
        Shows a progress bar after two seconds.

    Source: Shen 1993, sections 2.2.2.2, 2.2.2.3 and 2.5.
    """
    shares = system.area / system.area.sum()
    reflected = system.reflectance / np.maximum(1.0 - shares @ system.reflectance, 0.01)

    def missing(state):
        """What absolute amounts of unshot light would add if they met all patches evenly, over the radiosities."""
        if watch is not None:
            watch(state)
        left = reflected * (shares @ np.abs(state.residual))
        found, least = (np.sqrt(shares @ light ** 2) for light in (state.radiosity + state.ambient, left))
        return np.divide(least, found, out=np.where(least > 0, np.inf, 0.0), where=found > 0)

    return iterate(shooting.states(system), tolerance=shooting.tolerance, max_steps=_SHOTS * len(system),
                   progress=progress, error=missing)
