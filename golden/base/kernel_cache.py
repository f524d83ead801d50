"""Kernel cache: machine code of compiled functions in files, each named by all that it is made from."""

import contextlib
import fcntl
import hashlib
import os
import pickle
import platform
import tempfile
from functools import cache
from importlib.metadata import version
from pathlib import Path

from golden.base.kernel_digest import kernel_digest

__all__ = ["MOST_FILES", "KernelCache", "kernel_folder"]

# Of a function; those used longest ago go first, and are made again when they are needed.
MOST_FILES = 32
# Folders of the functions that this process is compiling.
_locked: set[Path] = set()


def kernel_folder() -> Path | None:
    """The folder of all machine code: ``$NUMBA_CACHE_DIR``, else ``radiosity-engine/kernels`` of the user's cache.

    None if the user has no folder.
    """
    if given := os.environ.get("NUMBA_CACHE_DIR"):
        return Path(given)
    try:
        users = Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser())
    except RuntimeError:
        return None
    return users / "radiosity-engine" / "kernels"


class KernelCache:
    """The machine code of one function, for numba's dispatcher, which calls these methods.

    The name of a file is a digest of the function and of all that it can call and read (`kernel_digest`), of the types
    of its arguments, of the processor, of the versions of Python, numba, LLVM and numpy, and of numba's settings. So
    nothing is read that other code has made, and processes that write at the same time write the same. What cannot be
    read is compiled, by one process at a time: others that need it wait and read it. What cannot be written is kept for
    this process only.
    """

    def __init__(self, dispatcher):
        self._dispatcher, folder = dispatcher, kernel_folder()
        name = f"{dispatcher.__module__}.{dispatcher.__qualname__}".replace("<locals>", "-")
        self._folder, self._lock = folder and folder / name, None

    @property
    def cache_path(self) -> str:
        """The folder of the function."""
        return str(self._folder)

    def load_overload(self, signature, target_context):
        """The function compiled for a signature; None if no file has it: it is compiled before `release`."""
        # So that what reading needs is initialized.
        target_context.refresh()
        path = self._path(signature, target_context)
        code = _stored(path)
        if code is None and self._acquire():
            # Another process may have compiled it meanwhile.
            code = _stored(path)
        if code is None:
            return None
        with contextlib.suppress(OSError):
            os.utime(path)
        from numba.core.compiler import CompileResult
        return CompileResult._rebuild(target_context, *pickle.loads(code))

    def _acquire(self) -> bool:
        """Wait until no other process compiles the function; False if none can be excluded.

        A process that waits holds functions that call this one, which calls none of them: none waits for ever.
        """
        # Functions that are made by one function share a folder, and may call each other.
        if self._folder is None or self._folder in _locked:
            return False
        with contextlib.suppress(OSError), contextlib.ExitStack() as opened:
            self._folder.mkdir(parents=True, exist_ok=True)
            descriptor = os.open(self._folder, os.O_RDONLY)
            opened.callback(os.close, descriptor)
            fcntl.flock(descriptor, fcntl.LOCK_EX)
            _locked.add(self._folder)
            opened.callback(_locked.discard, self._folder)
            self._lock = opened.pop_all()
            return True
        return False

    def release(self) -> None:
        """Let other processes compile the function: it is kept, or has failed to compile."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def save_overload(self, signature, result) -> None:
        """Keep the function as it has been compiled for a signature."""
        path = self._path(signature, result.target_context)
        if path is None or result.lifted or result.library.has_dynamic_globals:
            return
        from numba.core.serialize import dumps
        code = dumps(result._reduce())
        with contextlib.suppress(OSError):
            self._folder.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(dir=self._folder, prefix="part-", delete=False) as part:
                part.write(hashlib.sha256(code).digest() + code)
            os.replace(part.name, path)
            self._prune()

    def flush(self) -> None:
        """Remove nothing: what a file has is what compiling would give."""

    def _path(self, signature, target_context):
        """The file of a signature; None if there is no folder, or the function reads what has no digest."""
        digest = self._folder and kernel_digest(self._dispatcher)
        if digest is None:
            return None
        from numba.core.sigutils import normalize_signature
        arguments, result = normalize_signature(signature)
        parts = digest, *map(_text, arguments), result, target_context.codegen().magic_tuple(), _versions()
        return self._folder / hashlib.sha256(repr(parts).encode()).hexdigest()[:40]

    def _prune(self):
        """Remove the files that were used longest ago, and parts that ended processes have left."""
        used = {}
        for path in self._folder.iterdir():
            with contextlib.suppress(FileNotFoundError):  # another process prunes too
                used[path] = path.stat().st_mtime_ns
        for path in sorted(used, key=used.get)[:-MOST_FILES]:
            path.unlink(missing_ok=True)


def _stored(path):
    """What a file has, or None: there is none, or it is damaged."""
    try:
        stored = path.read_bytes()
    except (OSError, AttributeError):
        return None
    return stored[32:] if hashlib.sha256(stored[32:]).digest() == stored[:32] else None


@cache
def _versions():
    from numba import config
    return (platform.python_version(), *(version(package) for package in ("numba", "llvmlite", "numpy")),
            int(config.OPT), config.BOUNDSCHECK)


def _text(kind):
    """A type with the names of its fields, which its own text does not have."""
    from numba.core import types
    if not isinstance(kind, types.BaseTuple):
        return str(kind)
    made = getattr(kind, "instance_class", tuple)
    return made.__module__, made.__qualname__, getattr(made, "_fields", ()), *map(_text, kind)
