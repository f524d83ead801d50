"""Embree's library, as the wheel of embreex carries it, called through its own C interface."""

import ctypes
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from golden.base.compiled import is_compiler_active

__all__ = ["embree_library", "has_embree"]

_ADDRESS, _WHOLE, _SIZE = ctypes.c_void_p, ctypes.c_uint, ctypes.c_size_t
# Functions with what they return and take.
_FUNCTIONS = {
    "rtcNewDevice": (_ADDRESS, [ctypes.c_char_p]),
    "rtcGetDeviceError": (_WHOLE, [_ADDRESS]),
    "rtcNewScene": (_ADDRESS, [_ADDRESS]),
    "rtcSetSceneFlags": (None, [_ADDRESS, _WHOLE]),
    "rtcNewGeometry": (_ADDRESS, [_ADDRESS, _WHOLE]),
    "rtcSetSharedGeometryBuffer": (None, [_ADDRESS, _WHOLE, _WHOLE, _WHOLE, _ADDRESS, _SIZE, _SIZE, _SIZE]),
    "rtcCommitGeometry": (None, [_ADDRESS]),
    "rtcAttachGeometry": (_WHOLE, [_ADDRESS, _ADDRESS]),
    "rtcReleaseGeometry": (None, [_ADDRESS]),
    "rtcCommitScene": (None, [_ADDRESS]),
    "rtcReleaseScene": (None, [_ADDRESS]),
    "rtcIntersect1": (None, [_ADDRESS] * 3),
    "rtcOccluded1": (None, [_ADDRESS] * 3),
    "rtcPointQuery": (ctypes.c_bool, [_ADDRESS] * 5),
    "rtcIntersect8": (None, [_ADDRESS] * 4),
}
# Where tools that repair wheels put libraries, on Linux and Windows, and on macOS.
_FOLDERS = ("../embreex.libs", ".dylibs")


@cache
def _file() -> Path | None:
    """The library beside the package; None without the wheel."""
    package = find_spec("embreex")
    if package is None:
        return None
    folder = Path(package.origin).parent
    return next((path for name in _FOLDERS for path in sorted((folder / name).glob("*embree4*"))), None)


@cache
def has_embree() -> bool:
    """Whether Embree can be called: there is the wheel of embreex, and a compiler for what calls it."""
    return is_compiler_active() and _file() is not None


@cache
def embree_library() -> ctypes.CDLL:
    """The library, with the types of the functions that are called.

    Raises
    ------
    ModuleNotFoundError
        There is no wheel of embreex.
    """
    path = _file()
    if path is None:
        raise ModuleNotFoundError("embreex is not installed", name="embreex")
    library = ctypes.CDLL(str(path))
    for name, (result, arguments) in _FUNCTIONS.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library
