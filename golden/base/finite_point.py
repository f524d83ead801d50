"""A user's point or direction."""

import numpy as np

from golden.base.errors import InputError

__all__ = ["finite_point"]


def finite_point(name: str, value: object, *, parameter: str) -> np.ndarray:
    """Three finite numbers as float64.

    Raises
    ------
    InputError
        They are none, see there for ``parameter``; ``name`` has the subject before it.
    """
    try:
        point = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError):
        point = np.empty(0)
    if point.shape != (3,) or not np.isfinite(point).all():
        raise InputError(f"{name} must be three finite numbers, not {value!r}", parameter=parameter)
    return point
