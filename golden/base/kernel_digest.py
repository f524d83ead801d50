"""Digest of all that a compiled function is made from: its code, that of functions it can call, and constants."""

import hashlib
from collections.abc import Callable, Iterator
from enum import Enum
from types import CodeType, FunctionType, ModuleType

import numpy as np

__all__ = ["kernel_digest"]

_CODE = ("co_name", "co_code", "co_names", "co_varnames", "co_cellvars", "co_freevars", "co_flags", "co_argcount",
         "co_posonlyargcount", "co_kwonlyargcount", "co_exceptiontable")
_PLAIN = bool, int, float, complex, str, bytes, type(None), type(...), np.generic


def kernel_digest(function: Callable) -> str | None:
    """SHA-256 of what the machine code of a function depends on, as hexadecimal digits.

    The compiler freezes into it the functions that the function can call and the constants that it reads, from whatever
    files they are. The digest follows them from global names and closures, through tuples and modules: functions by
    their bytecode, constants by their values. A change of neither, such as that of a comment, is none of the digest.

    None if the function reads an object of its package that is none of these.
    """
    digest = _Digest(function.__module__)
    try:
        digest.add(function)
    except _UnknownError:
        return None
    return digest.hash.hexdigest()


class _UnknownError(Exception):
    """Of an object that has no description."""


class _Digest:
    """A walk from a function of a module; functions that have been met count as their numbers."""

    def __init__(self, module):
        self.hash, self._package, self._seen = hashlib.sha256(), module.partition(".")[0], {}

    def add(self, value):
        """Add what a compiled function can read or call."""
        if isinstance(value, _PLAIN):
            self._put(type(value).__name__, repr(value))
        elif isinstance(value, tuple | list):
            # Names of a tuple's entries are read as attributes.
            self._put(type(value).__name__, len(value), *getattr(value, "_fields", ()))
            for one in value:
                self.add(one)
        elif isinstance(value, frozenset):
            self._put("set", sorted(map(repr, value)))
        elif isinstance(value, np.ndarray):
            self._put("array", value.dtype, value.shape, value.tobytes())
        elif isinstance(value, CodeType):
            self._put("code", *(getattr(value, name) for name in _CODE))
            self.add(value.co_consts)
        elif hasattr(value, "py_func"):
            self._put("compiled", sorted(value.targetoptions.items()))
            self._add_function(value.py_func)
        elif isinstance(getattr(value, "__wrapped__", None), FunctionType):  # it writes machine code
            self._put("intrinsic")
            self._add_function(value.__wrapped__)
        elif not self._is_own(value):
            # The versions of other packages are in the names of the files of machine code.
            self._put("other", getattr(value, "__module__", None), getattr(value, "__qualname__", repr(value)))
        elif isinstance(value, FunctionType):
            self._add_function(value)
        elif isinstance(value, type):
            self._put("class", value.__module__, value.__qualname__, getattr(value, "_fields", ()),
                      [(one.name, one.value) for one in value] if issubclass(value, Enum) else ())
        elif not isinstance(value, ModuleType):  # the attributes of which are read by name
            raise _UnknownError

    def _is_own(self, value):
        name = value.__name__ if isinstance(value, ModuleType) else getattr(value, "__module__", type(value).__module__)
        return name.partition(".")[0] == self._package

    def _add_function(self, function):
        if function in self._seen:
            self._put("seen", self._seen[function])
            return
        self._seen[function] = len(self._seen)
        self._put("function", function.__module__, function.__qualname__)
        self.add((function.__code__, function.__defaults__, *(function.__kwdefaults__ or {}).items(),
                  *(cell.cell_contents for cell in function.__closure__ or ())))
        names = sorted(set(_names(function.__code__)))
        modules = [function.__globals__]
        for module in modules:
            for name in names:
                if name not in module:
                    continue
                self._put("name", name)
                self.add(module[name])
                if isinstance(module[name], ModuleType) and self._is_own(module[name]):
                    attributes = vars(module[name])
                    if all(attributes is not one for one in modules):
                        modules.append(attributes)

    def _put(self, *parts):
        self.hash.update(repr(parts).encode())


def _names(code) -> Iterator[str]:
    """The global names and attributes that code and what is defined in it read."""
    yield from code.co_names
    for one in code.co_consts:
        if isinstance(one, CodeType):
            yield from _names(one)
