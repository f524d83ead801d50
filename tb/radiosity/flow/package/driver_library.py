"""The exported driver as a library, and its types for ctypes."""

import ctypes
import subprocess
from pathlib import Path

from radiosity.flow.package.software.driver_files import driver_files

__all__ = ["FLAGS", "Completion", "Engine", "Fault", "Hit", "JobPlace", "PortFunctions", "build_driver",
           "complaints"]

FLAGS = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
_U8, _U16, _U32, _U64, _POINTER = (
    ctypes.c_uint8, ctypes.c_uint16, ctypes.c_uint32, ctypes.c_uint64, ctypes.c_void_p)


def _structure(name, *fields):
    return type(name, (ctypes.Structure,), {"_fields_": list(fields)})


def _numbers(kind, names):
    return [(name, kind) for name in names.split()]


PortFunctions = _structure(
    "PortFunctions", ("context", _POINTER),
    ("read", ctypes.CFUNCTYPE(ctypes.c_int, _POINTER, _U32, ctypes.POINTER(_U32))),
    ("write", ctypes.CFUNCTYPE(ctypes.c_int, _POINTER, _U32, _U32)),
    ("read_memory", ctypes.CFUNCTYPE(ctypes.c_int, _POINTER, _U64, _POINTER, ctypes.c_size_t)),
    ("write_memory", ctypes.CFUNCTYPE(ctypes.c_int, _POINTER, _U64, _POINTER, ctypes.c_size_t)),
    ("wait", ctypes.CFUNCTYPE(ctypes.c_int, _POINTER, ctypes.c_int)))
JobPlace = _structure("JobPlace", *_numbers(_U64, "base end ring completions image"),
                      *_numbers(_U32, "ring_bits policy copies"))
Engine = _structure("Engine", ("port", ctypes.POINTER(PortFunctions)), ("job", JobPlace),
                    *_numbers(_U32, "clusters submitted collected"), ("has_interrupts", ctypes.c_int))
Completion = _structure(
    "Completion", ("address", _U64),
    *_numbers(_U32, "sums cycles begin end tested visited steps found own remote hits misses tag"),
    *_numbers(_U8, "error cluster"), ("lap", _U16))
Fault = _structure("Fault", *_numbers(_U32, "error cluster"), ("address", _U64))
Hit = _structure("Hit", ("patch", ctypes.c_int64), ("inverse", _U32), ("u", _U16), ("v", _U16))


def complaints(folder: Path, *command: str | Path) -> str:
    """What a compiler prints that runs in a folder; at least its exit code if it fails."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    return done.stdout + done.stderr + (f"exit code {done.returncode}" if done.returncode else "")


def build_driver(folder: Path) -> ctypes.CDLL:
    """Compile the driver in a folder, where its files stay, without a warning."""
    for name, text in driver_files().items():
        (folder / name).write_text(text)
    assert not complaints(folder, "gcc", *FLAGS, "-fPIC", "-shared", "-o", "radiosity.so", "radiosity.c")
    library = ctypes.CDLL(str(folder / "radiosity.so"))
    for name in "error_name", "error_text", "counter_name", "result_text":
        getattr(library, f"radiosity_{name}").restype = ctypes.c_char_p
    return library
