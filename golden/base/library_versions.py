"""Versions of the libraries whose code computes results."""

from functools import cache
from importlib.metadata import PackageNotFoundError, version

from golden.base.compiled import is_compiler_active

__all__ = ["library_versions"]

_ALWAYS = ("numpy", "scipy")
_COMPILER = ("numba", "llvmlite")


@cache
def library_versions(method: str | None = None) -> dict[str, str]:
    """Version of each library that computes beside the sources of this package, by its name.

    The same sources round otherwise with another version: what must be of the same code (`source_digest`) compares
    these too. A library that is not installed has "none", and so have those of the compiler where it is not active.

    Parameters
    ----------
    method
        The casting method: that of Embree has its library too.
    """
    compiler = {name: _version(name) if is_compiler_active() else "none" for name in _COMPILER}
    others = (*_ALWAYS, *(["embreex"] if method == "embree" else []))
    return {**{name: _version(name) for name in others}, **compiler}


def _version(name):
    try:
        return version(name)
    except PackageNotFoundError:
        return "none"
