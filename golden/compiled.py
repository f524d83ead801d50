"""Compilation of inner loops by numba, where it is installed."""

from collections.abc import Callable
from importlib.util import find_spec

__all__ = ["compiled"]


def compiled(function: Callable) -> Callable:
    """Compile a function to machine code at its first call, with the arithmetic of numpy.

    Every operation rounds by itself (no fast-math, no fused multiply-add), and a division by zero gives an infinity or
    NaN, so the function computes the bits of the same operations in numpy. It runs beside other threads. The code is
    kept in ``__pycache__`` beside the source, else in the user's cache folder, else for this process only.

    Without numba, or with 1 in the environment variable ``NUMBA_DISABLE_JIT``, Python runs the function as it is.
    """
    if find_spec("numba") is None:
        return function
    import numba
    options = {"nogil": True, "error_model": "numpy"}
    try:
        return numba.njit(cache=True, **options)(function)
    except RuntimeError:  # no folder for the code can be written
        return numba.njit(**options)(function)
