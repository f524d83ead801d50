"""Kernels of machines that Python runs as they are written."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from golden.compiled import is_compiler_active

__all__ = ["interpreted_kernels"]


@contextmanager
def interpreted_kernels() -> Iterator[None]:
    """A context in which Python runs the kernels of machines: compiling one takes longer than many small runs."""
    with pytest.MonkeyPatch.context() as patch:
        if is_compiler_active():
            from golden.kernel_dispatcher import KernelDispatcher

            def call(kernel, *given, **named):
                is_machine = kernel.py_func.__module__.startswith("golden.machines")
                return (kernel.py_func if is_machine else super(KernelDispatcher, kernel).__call__)(*given, **named)

            patch.setattr(KernelDispatcher, "__call__", call, raising=False)
        yield
