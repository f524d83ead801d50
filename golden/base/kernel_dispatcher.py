"""Kernel dispatcher: compiles a function for types of arguments, with and without an entry for Python."""

from functools import cached_property

from numba.core.registry import CPUDispatcher
from numba.core.targetconfig import TargetConfig
from numba.core.types import CPointer, uintp, unliteral

from golden.base.kernel_cache import KernelCache
from golden.base.without_collection import without_collection

__all__ = ["INLINED", "CallbackDispatcher", "KernelDispatcher"]

# Arithmetic of numpy, beside other threads; no entry for C, from which nothing calls.
_OPTIONS = {"nopython": True, "boundscheck": None, "nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
_WITHOUT_ENTRY = {**_OPTIONS, "no_cpython_wrapper": True}

INLINED = {**_WITHOUT_ENTRY, "forceinline": True}
"""Options of a function that becomes a part of each kernel that calls it."""


_compare = TargetConfig.__eq__


def _equal(self, other):
    """Whether two compilations have the same options.

    numba looks them up for every operation of a function, and compares the values of all options, most of which are not
    set: a fifth of a compilation.
    """
    return (type(self) is type(other) and self._values == other._values) or _compare(self, other)


TargetConfig.__eq__ = _equal
# numba's own hash is that of the options' names.
TargetConfig.__hash__ = lambda self: hash(type(self))


class _CachedDispatcher(CPUDispatcher):
    """A dispatcher whose machine code one process compiles and others read."""

    def __init__(self, py_func, targetoptions):
        super().__init__(py_func, {}, targetoptions)
        self._cache = KernelCache(self)

    def compile(self, sig):
        """Compile the function for types of arguments, unless it is or a file has it."""
        try:
            with without_collection():
                return super().compile(sig)
        finally:
            self._cache.release()


class KernelDispatcher(_CachedDispatcher):
    """A compiled function, as Python calls it. Other kernels call a twin of it that has no entry for Python.

    An entry takes arguments apart, for which more is compiled than for most functions whose state is in many arrays.
    What a kernel passes as a constant has its plain type, not one of its value, for each of which numba would compile
    the function once more. Kernels do not call themselves.
    """

    def __init__(self, py_func, locals=None, targetoptions=None, pipeline_class=None):
        super().__init__(py_func, targetoptions or _OPTIONS)
        self._twin = None if "no_cpython_wrapper" in self.targetoptions else KernelDispatcher(
            py_func, targetoptions=_WITHOUT_ENTRY)

    def get_call_template(self, args, kws):
        """Types of a call from another kernel, for which the twin is compiled."""
        if self._twin is not None:
            return self._twin.get_call_template(args, kws)
        return super().get_call_template([unliteral(one) for one in args],
                                         {name: unliteral(one) for name, one in kws.items()})

    def get_overload(self, sig):
        """What another kernel calls."""
        return super().get_overload(sig) if self._twin is None else self._twin.get_overload(sig)


class CallbackDispatcher(_CachedDispatcher):
    """A compiled function of one pointer, as C calls it."""

    def __init__(self, py_func):
        super().__init__(py_func, {**_WITHOUT_ENTRY, "no_cfunc_wrapper": False})

    @cached_property
    def address(self) -> int:
        """Where it is; it is compiled when this is first read."""
        arguments = CPointer(uintp),
        self.compile(arguments)
        result = self.overloads[arguments]
        return result.library.get_pointer_to_function(result.fndesc.llvm_cfunc_wrapper_name)
