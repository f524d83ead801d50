"""Where generated Verilog and compiled simulators are kept, by a hash of all that they are made from."""

import fcntl
import hashlib
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

__all__ = ["MOST_BYTES", "build_folder", "content_key", "keep_newest", "locked", "temporary_folder"]

_CHECKOUT = Path(__file__).parents[3]
# Of each kind of build; those used longest ago go first, and are made again when they are needed.
MOST_BYTES = 24 << 20


def build_folder() -> Path:
    """The folder of all builds: ``$RADIOSITY_BUILD``, ``build/simulator`` of a checkout, or the user's cache."""
    if given := os.environ.get("RADIOSITY_BUILD"):
        return Path(given).resolve()
    if (_CHECKOUT / "pyproject.toml").exists():
        return _CHECKOUT / "build" / "simulator"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "radiosity-engine"


def content_key(*sources) -> str:
    """A name for what is made from these sources."""
    return hashlib.sha256("\0".join(map(str, sources)).encode()).hexdigest()[:24]


@contextmanager
def locked(folder: Path, *, shared: bool = False) -> Iterator[None]:
    """Exclusive access to a folder among all processes, several of which may request the same build; shared access
    keeps others from changing or removing it.
    """
    with folder.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_SH if shared else fcntl.LOCK_EX)
        yield


@contextmanager
def temporary_folder(name: str) -> Iterator[Path]:
    """An empty folder for the intermediate files of a build, which is removed at the end.

    Folders that killed processes have left are removed at the beginning.
    """
    parent = build_folder() / "parts"
    parent.mkdir(parents=True, exist_ok=True)
    keep_newest(parent, most=0)
    folder = parent / name
    with locked(folder):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)


def keep_newest(parent: Path, *, most: int = MOST_BYTES, built: Path | None = None) -> None:
    """Remove the entries of a folder that were used longest ago, until the rest fits in ``most`` bytes.

    What a process has `locked`, and what has just been ``built``, stays and is not counted.
    """
    used = 0
    for entry in sorted(parent.iterdir(), key=_last_use, reverse=True):
        if entry.suffix != ".lock" and entry != built:
            with _unlocked(entry) as is_free:
                if is_free:
                    used += sum(_size(path) for path in ([*entry.rglob("*")] if entry.is_dir() else [entry]))
                    if used > most:
                        _remove(entry)


@contextmanager
def _unlocked(entry):
    """Whether no process has an entry locked; then none can lock it in the block."""
    lock = entry.with_suffix(".lock")
    with lock.open("w") if lock.exists() else nullcontext() as file:
        try:
            if file is not None:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            yield False
        else:
            yield True


def _remove(entry):
    if entry.is_dir():
        shutil.rmtree(entry, ignore_errors=True)
    else:
        entry.unlink(missing_ok=True)


def _last_use(path):
    """When it was used; another process may have removed it."""
    return path.stat().st_mtime if path.exists() else 0


def _size(path):
    try:
        return path.stat().st_size
    except FileNotFoundError:
        return 0
