"""Compilation of inner loops by numba, where it is installed."""

import os
from collections.abc import Callable
from functools import cache
from importlib import import_module

__all__ = ["callback", "compiled", "inlined", "is_compiler_active"]


@cache
def is_compiler_active() -> bool:
    """Whether `compiled` compiles: numba is there, accepts the installed numpy, and is not switched off.

    1 in the environment variable ``NUMBA_DISABLE_JIT`` switches it off.
    """
    if os.environ.get("NUMBA_DISABLE_JIT", "0") == "1":
        return False
    try:
        import_module("numba")
    except ImportError:
        return False
    return True


def compiled(function: Callable) -> Callable:
    """Compile a function to machine code at its first call, with the arithmetic of numpy.

    Every operation rounds by itself (no fast-math, no fused multiply-add), and a division by zero gives an infinity or
    NaN, so the function computes the bits of the same operations in numpy. It runs beside other threads. The code is
    kept for other processes (`KernelCache`), where the user has a folder for it.

    Where the compiler is not active, Python runs the function as it is.
    """
    if not is_compiler_active():
        return function
    from golden.base.kernel_dispatcher import KernelDispatcher
    return KernelDispatcher(function)


def inlined(function: Callable) -> Callable:
    """Compile a function into each compiled one that calls it, whose loops then take several values at once."""
    if not is_compiler_active():
        return function
    from golden.base.kernel_dispatcher import INLINED, KernelDispatcher
    return KernelDispatcher(function, targetoptions=INLINED)


def callback(function: Callable) -> Callable:
    """Compile a function, as `compiled` does, for a C library to call with one address; its own is its ``address``.

    For the function the address is a pointer to others, ``numba.types.uintp``.
    """
    from golden.base.kernel_dispatcher import CallbackDispatcher
    return CallbackDispatcher(function)
