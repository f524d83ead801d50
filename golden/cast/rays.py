"""Rays and their hits in float64."""

from dataclasses import dataclass

import numpy as np

from golden.base.compiled import compiled
from golden.base.errors import InputError
from golden.base.plural import counted

__all__ = ["Hits", "Rays"]

# Least and greatest length of a direction, as its largest component: its square must neither overflow nor vanish.
SHORTEST, LONGEST = 2.0**-300, 2.0**300


@dataclass(frozen=True, eq=False, repr=False)
class Rays:
    """R rays; ``t`` along a ray is in units of its direction's length.

    Parameters
    ----------
    origin, direction
        R x 3 float64; directions need not be unit vectors.
    source
        R int32: the surface (``Scene.surface``) on which the ray starts and which it never hits, or -1.
    tmax
        R float64: hits at this distance or farther do not count; infinity by default.
    target
        R int32: another surface that the ray never hits, or -1.

    Raises
    ------
    InputError
        Shapes do not match, a value is not finite, or the largest component of a direction is zero or not between
        2^-300 and 2^300.
    """

    origin: np.ndarray
    direction: np.ndarray
    # None is replaced by what it stands for.
    source: np.ndarray = None  # type: ignore[assignment]
    tmax: np.ndarray = None  # type: ignore[assignment]
    target: np.ndarray = None  # type: ignore[assignment]

    def __post_init__(self):
        for name in ("origin", "direction"):
            value = np.ascontiguousarray(getattr(self, name), dtype=np.float64)
            object.__setattr__(self, name, value)
            if value.ndim != 2 or value.shape[1] != 3:
                raise InputError(f"rays: {name.capitalize()} must be R x 3, not {value.shape!r}", parameter=name)
        count = len(self.origin)
        if len(self.direction) != count:
            raise InputError(f"rays: Direction must have as many rows as origin, not {len(self.direction)} for {count}",
                             parameter="direction")
        if not _all_castable(self.origin, self.direction):
            self._refuse_others()
        endless = self.tmax is None
        for name, dtype, default in (("source", np.int32, -1), ("tmax", np.float64, np.inf), ("target", np.int32, -1)):
            value = getattr(self, name)
            value = np.full(count, default, dtype) if value is None else np.ascontiguousarray(value, dtype=dtype)
            if value.shape != (count,):
                raise InputError(f"rays: {name.capitalize()} must have one entry for each of {count} rays, "
                                 f"not shape {value.shape!r}", parameter=name)
            object.__setattr__(self, name, value)
        if not (endless or (self.tmax >= 0).all()):
            raise InputError("rays: Tmax must be at least 0 and not NaN", parameter="tmax")

    def _refuse_others(self):
        """Name the first ray that is not castable."""
        for name in ("origin", "direction"):
            value = getattr(self, name)
            bad = np.flatnonzero(~np.isfinite(value).all(axis=1))
            if len(bad):
                raise InputError(f"rays: {name.capitalize()} of ray {bad[0]} must be finite, not {value[bad[0]]!r}",
                                 parameter=name)
        longest = _longest_component(self.direction)
        bad = np.flatnonzero(longest == 0)
        if len(bad):
            raise InputError(f"rays: Direction of ray {bad[0]} must not be zero", parameter="direction")
        bad = np.flatnonzero((longest < SHORTEST) | (longest > LONGEST))
        if len(bad):
            raise InputError(f"rays: Direction of ray {bad[0]} must be {SHORTEST:.0e} to {LONGEST:.0e} long, not "
                             f"{longest[bad[0]]!r}", parameter="direction")

    def __len__(self) -> int:
        return len(self.origin)

    def __repr__(self) -> str:
        return f"<Rays: {counted(len(self), 'ray')}>"

    def __getitem__(self, rows) -> "Rays":
        return Rays(self.origin[rows], self.direction[rows], self.source[rows], self.tmax[rows], self.target[rows])


@dataclass(frozen=True, eq=False, repr=False)
class Hits:
    """Hits of R rays.

    Parameters
    ----------
    patch
        R int32, the nearest patch (the smaller number of two equally near ones), or -1.
    t
        R float64, distance in units of the direction's length; infinity where ``patch`` is -1.
    u, v
        R float64, bilinear coordinates on the patch: (0, 0) at vertex 0, (1, 0) at 1, (1, 1) at 2, (0, 1) at 3.
    tests, steps
        R int64, ray-patch tests and cell steps of the casting method.
    """

    patch: np.ndarray
    t: np.ndarray
    u: np.ndarray
    v: np.ndarray
    tests: np.ndarray
    steps: np.ndarray

    def __getitem__(self, rows) -> "Hits":
        return Hits(**{name: values[rows] for name, values in vars(self).items()})

    def __repr__(self) -> str:
        return f"<Hits: {np.count_nonzero(self.patch >= 0)} of {counted(len(self.patch), 'ray')}>"


@compiled
def _all_castable(origin, direction):
    """Whether all origins are finite and all directions neither too short nor too long."""
    for ray in range(len(origin)):
        longest = 0.0
        for axis in range(3):
            component = abs(direction[ray, axis])
            if not (np.isfinite(origin[ray, axis]) and component <= LONGEST):
                return False
            longest = max(longest, component)
        if longest < SHORTEST:
            return False
    return True


def _longest_component(vectors):
    """The largest absolute component of each of R vectors."""
    x, y, z = np.abs(vectors).T
    return np.maximum(np.maximum(x, y), z)
