"""The port of a simulated machine: a compiled library, so that no Python runs in a cycle."""

import ctypes
import os
from collections.abc import Coroutine
from pathlib import Path

from golden.engine.config import Config
from radiosity.flow.host import Port, RegisterError
from radiosity.flow.simulator.machine_library import machine_library

__all__ = ["SimulatedPort", "complete"]

_WHOLE = ctypes.c_uint64
_TYPES = {
    "make": (ctypes.c_void_p, ()), "free": (None, (ctypes.c_void_p,)), "reset": (None, (ctypes.c_void_p,)),
    "memory": (None, (ctypes.c_void_p, *[_WHOLE] * 6)), "data": (ctypes.c_void_p, (ctypes.c_void_p,)),
    "faults": (None, (ctypes.c_void_p, _WHOLE, _WHOLE, ctypes.c_int, ctypes.c_int)),
    "run": (None, (ctypes.c_void_p, _WHOLE)), "counts": (None, (ctypes.c_void_p, ctypes.POINTER(_WHOLE))),
    "read": (ctypes.c_int, (ctypes.c_void_p, ctypes.c_uint32, ctypes.POINTER(ctypes.c_uint32))),
    "write": (ctypes.c_int, (ctypes.c_void_p, ctypes.c_uint32, ctypes.c_uint32))}
_TRACED = {"trace": (None, (ctypes.c_void_p, ctypes.c_char_p))}


def complete(coroutine: Coroutine):
    """Run a coroutine that awaits nothing, a driver's at a `SimulatedPort`, and return its result.

    Raises
    ------
    RuntimeError
        The coroutine awaits something.
    """
    try:
        coroutine.send(None)
    except StopIteration as done:
        return done.value
    raise RuntimeError("The driver must wait for nothing but its port")


class SimulatedPort(Port):
    """Registers and main memory of a simulated machine. None of its coroutines awaits anything, see `complete`.

    Parameters
    ----------
    config
        The configuration.
    size, base
        Bytes of main memory, and the address of the first one.
    latency
        Cycles from a read to its first beat, at least 1.
    spread
        Most random extra cycles of a read.
    shuffles
        Beats of different reads come in any order.
    seed
        Of the random numbers.
    traced
        `trace` can be called.
    library
        The compiled machine. Default: that of the configuration.
    progress
        Show the progress of a build.

    Members
    -------
    size
        Bytes of main memory.
    cycles, read_beats, written_beats, outside
        Totals since the start: clock cycles, beats read and written, and beats at addresses outside main memory.
    """

    def __init__(self, config: Config, *, size: int, base: int = 0, latency: int = 10, spread: int = 0,
                 shuffles: bool = False, seed: int = 1, traced: bool = False, library: Path | None = None,
                 progress: bool = False):
        self._library = ctypes.CDLL(str(library or machine_library(config, traced=traced, progress=progress)))
        for name, (result, arguments) in (_TYPES | (_TRACED if traced else {})).items():
            function = getattr(self._library, f"machine_{name}")
            function.restype, function.argtypes = result, arguments
        self._base = base
        self._memory = latency, spread, int(shuffles), seed
        self._machine = self._library.machine_make()
        self.resize(size)

    def resize(self, size: int) -> None:
        """Set the size of main memory and restart its random numbers. The contents stay."""
        self.size = size
        self._library.machine_memory(self._machine, self._base, size, *self._memory)

    def fault(self, *, first: int = 0, size: int = 0, mute_reads: bool = False, mute_writes: bool = False) -> None:
        """Let main memory fail from now on; without arguments it is sound again.

        Parameters
        ----------
        first, size
            Beats of these bytes are answered with an error and neither read nor written.
        mute_reads, mute_writes
            Reads, or writes, are not answered until memory is sound again.
        """
        self._library.machine_faults(self._machine, first, first + size, int(mute_reads), int(mute_writes))

    def trace(self, path: Path | None) -> None:
        """Write the signals of the next cycles (VCD, two units of time for a cycle); without a path, stop."""
        self._library.machine_trace(self._machine, None if path is None else os.fsencode(path))

    def close(self) -> None:
        """Free the library's memory."""
        if self._machine:
            self._library.machine_free(self._machine)
        self._machine = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _counts(self):
        counts = (_WHOLE * 4)()
        self._library.machine_counts(self._machine, counts)
        return counts

    @property
    def cycles(self) -> int:
        """Clock cycles since the start."""
        return self._counts()[0]

    @property
    def read_beats(self) -> int:
        """Beats read from main memory."""
        return self._counts()[1]

    @property
    def written_beats(self) -> int:
        """Beats written to main memory."""
        return self._counts()[2]

    @property
    def outside(self) -> int:
        """Beats at addresses outside main memory."""
        return self._counts()[3]

    def reset(self) -> None:
        """Reset the machine and its memory port. The contents of main memory stay."""
        self._library.machine_reset(self._machine)

    async def read(self, address: int) -> int:
        """Read a register."""
        value = ctypes.c_uint32()
        self._check(self._library.machine_read(self._machine, address, value), address)
        return value.value

    async def write(self, address: int, value: int) -> None:
        """Write a register."""
        self._check(self._library.machine_write(self._machine, address, value), address)

    @staticmethod
    def _check(response, address):
        if response:
            raise RegisterError(f"the register at {address:#x} answers with response {response}")

    def _locate(self, address, size):
        first = address - self._base
        if not 0 <= first <= self.size - size:
            raise ValueError(f"Memory must hold {size} bytes at {address:#x}")
        return self._library.machine_data(self._machine) + first

    async def read_memory(self, address: int, size: int) -> bytes:
        """Read bytes of main memory."""
        return ctypes.string_at(self._locate(address, size), size)

    async def write_memory(self, address: int, data: bytes) -> None:
        """Write bytes to main memory."""
        ctypes.memmove(self._locate(address, len(data)), bytes(data), len(data))

    async def wait(self, cycles: int) -> None:
        """Advance the clock by so many cycles."""
        self._library.machine_run(self._machine, cycles)
