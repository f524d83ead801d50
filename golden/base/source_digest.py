"""Digest of all installed sources: which code computes."""

import hashlib
from functools import cache
from importlib.util import find_spec
from pathlib import Path

__all__ = ["PACKAGES", "source_digest"]

PACKAGES = ("golden", "hw", "radiosity")
"""Those that the distribution installs."""

# Bytes of a digest suffice to find a difference.
_DIGITS = 32


@cache
def source_digest() -> str:
    """Hexadecimal digits of a hash of the names and contents of all files of the installed packages, read once.

    A version names a release, and many commits have the same one. What must be of the same code (blocks of an
    unfinished run, workers) compares this digest. Files that the interpreter made, and hidden ones, do not count.
    """
    whole = hashlib.sha256()
    for package in PACKAGES:
        spec = find_spec(package)
        for folder in spec.submodule_search_locations if spec else ():
            for path in sorted(Path(folder).rglob("*")):
                name = path.relative_to(folder)
                if path.is_file() and not any(part == "__pycache__" or part.startswith(".") for part in name.parts):
                    content = path.read_bytes()
                    whole.update(f"{package}/{name.as_posix()} {len(content)}\n".encode())
                    whole.update(content)
    return whole.hexdigest()[:_DIGITS]
