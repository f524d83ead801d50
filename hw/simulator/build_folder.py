"""Where generated Verilog and compiled simulators are kept, by a hash of all that they are made from."""

import fcntl
import hashlib
import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

__all__ = ["MOST_BYTES", "build_folder", "content_key", "keep_newest", "locked"]

_CHECKOUT = Path(__file__).parents[2]
# What is built again before it is kept beyond this size.
MOST_BYTES = 60 << 20


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
def locked(folder: Path) -> Iterator[None]:
    """Exclusive access to a folder among all processes: several may request the same build."""
    with folder.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def keep_newest(parent: Path, *, most: int = MOST_BYTES) -> None:
    """Remove the entries of a folder that were used longest ago, until the rest fits in ``most`` bytes."""
    used = 0
    for entry in sorted(parent.iterdir(), key=lambda entry: entry.stat().st_mtime, reverse=True):
        files = entry.rglob("*") if entry.is_dir() else [entry]
        used += sum(path.stat().st_size for path in files if path.is_file())
        if used > most and entry.suffix != ".lock":
            if entry.is_dir():
                shutil.rmtree(entry, ignore_errors=True)
            else:
                entry.unlink(missing_ok=True)
