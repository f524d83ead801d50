"""Contents of the files that commands write, as digests: what must stay from commit to commit."""

import hashlib
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image

__all__ = ["digest"]


def digest(folder: Path) -> str:
    """SHA-256 over the contents of all files in a folder, by name, as 32 hexadecimal digits.

    Arrays and pixels count, not how a library packs them, and no text: a header may be reworded.
    """
    whole = hashlib.sha256()
    for path in sorted(folder.iterdir()):
        whole.update(path.name.encode())
        for name, array in _contents(path):
            whole.update(f"{name} {array.dtype.str} {array.shape}".encode())
            whole.update(np.ascontiguousarray(array).tobytes())
    return whole.hexdigest()[:32]


def _contents(path):
    """Name and array of each part of a file."""
    if path.suffix == ".npz":
        with np.load(path) as stored:
            return [(name, stored[name]) for name in sorted(stored.files) if stored[name].dtype.kind != "U"]
    if path.suffix == ".png":
        with Image.open(path) as picture:
            return [("pixels", np.asarray(picture))]
    if path.suffix == ".exr":
        with OpenEXR.File(str(path)) as picture:
            return [(name, channel.pixels) for name, channel in sorted(picture.channels().items())]
    return [("bytes", np.frombuffer(path.read_bytes(), dtype=np.uint8))]
