"""Blocks of rows on disk: what a killed run has finished, and another run continues."""

import hashlib
import json
from contextlib import suppress
from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.base.library_versions import library_versions
from golden.base.output import whole_file
from golden.base.source_digest import source_digest
from golden.scene.scene import Scene

__all__ = ["BlockStore", "scene_key"]

_KEY = "run.json"


def scene_key(scene: Scene) -> str:
    """SHA-256 of a scene's patches, as hexadecimal digits: what view factors depend on."""
    whole = hashlib.sha256()
    for array in (scene.vertices, scene.surface, scene.two_sided):
        whole.update(f"{array.dtype.str} {array.shape}".encode())
        whole.update(array.tobytes())
    return whole.hexdigest()


class BlockStore:
    """Blocks in a folder, a file for each, written atomically; `run.json` there states what they belong to.

    Parameters
    ----------
    folder
        Where blocks are; it is made when the first one is saved.
    key
        Names and values, all that the blocks depend on beside the code of this package and of the libraries; numbers
        and strings. Its ``method``, if any, is the casting method.
    resume
        Whether blocks of an earlier run are used.

    Raises
    ------
    InputError
        The folder has blocks of other work, or blocks although ``resume`` is false; it cannot be read.
    """

    def __init__(self, folder: Path, key: dict, *, resume: bool):
        self._folder = folder
        self._key = {**key, "sources": source_digest(), **library_versions(key.get("method"))}
        if not (folder / _KEY).exists():
            return
        if not resume:
            raise InputError(f"{folder}: it has blocks of an unfinished run: continue it by --resume, or delete it")
        try:
            stored = json.loads((folder / _KEY).read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise InputError(f"{folder}: it cannot be resumed, {_KEY} cannot be read") from error
        other = sorted(name for name in stored.keys() | self._key.keys() if stored.get(name) != self._key.get(name))
        if other:
            raise InputError(f"{folder}: it cannot be resumed, the unfinished run had other values of "
                             f"{', '.join(other)}")

    def load(self, first: int, kind: type):
        """The block of ``kind`` that begins with row ``first``, or None if it is not there."""
        path = self._path(first)
        if not path.exists():
            return None
        try:
            # Of a torn file numpy leaves open what it has opened itself.
            with path.open("rb") as file, np.load(file) as stored:
                return kind(**stored)
        except Exception as error:  # numpy raises errors of any type for bad content
            raise InputError(f"{path}: it is no block of view factors; delete it") from error

    def save(self, first: int, block) -> None:
        """Write a block, a dataclass of arrays."""
        if not (self._folder / _KEY).exists():
            self._folder.mkdir(exist_ok=True)
            with whole_file(self._folder / _KEY) as part:
                part.write_text(json.dumps(self._key, indent=1, sort_keys=True), encoding="utf-8")
        with whole_file(self._path(first)) as part:
            np.savez(part, **vars(block))

    def remove(self) -> None:
        """Delete the blocks, and the folder if nothing else is in it."""
        # A killed run leaves the temporary file that it was writing.
        for pattern in ("*rows-*.npz", "*run*.json"):
            for path in self._folder.glob(pattern):
                path.unlink()
        with suppress(OSError):
            self._folder.rmdir()

    def _path(self, first):
        return self._folder / f"rows-{first:08}.npz"
