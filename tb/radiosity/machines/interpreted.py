"""Kernels of machines that Python runs as they are written."""

import pytest

from golden.base.compiled import is_compiler_active

__all__ = ["interpreted"]


@pytest.fixture
def interpreted(request):
    """Python runs the kernels of machines, since compiling one takes longer than many small runs.

    Those of the nightly's tests are compiled.
    """
    with pytest.MonkeyPatch.context() as patch:
        if is_compiler_active() and not request.node.get_closest_marker("nightly"):
            from golden.base.kernel_dispatcher import KernelDispatcher

            def call(kernel, *given, **named):
                is_machine = kernel.py_func.__module__.startswith("radiosity.machines")
                return (kernel.py_func if is_machine else super(KernelDispatcher, kernel).__call__)(*given, **named)

            patch.setattr(KernelDispatcher, "__call__", call, raising=False)
        yield
