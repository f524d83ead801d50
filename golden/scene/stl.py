"""Reader of STL files, binary and text."""

import re
from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.scene.appearance import UNSPECIFIED
from golden.scene.file_text import lines_of, numbers
from golden.scene.mesh import Mesh
from golden.scene.parser import unreadable
from golden.scene.unused import Unused

__all__ = ["read_stl"]

_HEAD, _FACET = 84, 50
# A solid's name ends with its line and may hold any words.
_SOLID = re.compile(r"\s*(end\s*)?solid\b.*", re.IGNORECASE)
_TEXT = re.compile(r"\s*+facet\s++normal(?:\s++\S++){3}\s++outer\s++loop((?:\s++vertex(?:\s++\S++){3})*+)\s++"
                   r"end\s*+loop\s++end\s*+facet(?=\s|$)", re.IGNORECASE)


def read_stl(path: Path) -> Mesh:
    """The mesh of an STL file. Faces are two-sided, of one grey; the normals of the file are not read.

    Raises
    ------
    InputError
        The file is no STL file, ends too early or has facets of more than three corners; the message lacks the path.
    OSError
        The file cannot be read.

    Warns
    -----
    InputWarning
        Names attributes of facets, and bytes behind the last one.
    """
    data = path.read_bytes()
    expected = _HEAD + _FACET * int.from_bytes(data[80:_HEAD], "little")
    # Programs append less than a facet.
    is_binary = len(data) >= _HEAD and 0 <= len(data) - expected < _FACET
    points = _binary(data, expected) if is_binary else _text(data, expected)
    count = len(points) // 3
    return Mesh(points=points, counts=np.full(count, 3), corners=np.arange(3 * count),
                material=np.zeros(count, dtype=np.int64), materials=(UNSPECIFIED,), one_sided=np.zeros(1, dtype=bool))


def _binary(data, expected):
    facets = np.frombuffer(data[_HEAD:expected], dtype=[("numbers", "<f4", (4, 3)), ("attribute", "<u2")])
    unused = Unused()
    unused.add("attributes of facets", bool(facets["attribute"].any()))
    unused.add("bytes behind the last facet", len(data) - expected)
    unused.warn()
    return facets["numbers"][:, 1:].reshape(-1, 3).astype(np.float64)


def _text(data, expected):
    lines = lines_of(data)
    if not data.strip():
        return np.empty((0, 3))
    if any("\0" in line for line in lines) or not _SOLID.match(next((line for line in lines if line.strip()), "")):
        raise unreadable("STL", f"it is {len(data)} bytes long and should be {expected}" if len(data) >= _HEAD
                         else "it begins neither with a header of 84 bytes nor with 'solid'")
    text = "\n".join("" if _SOLID.match(line) else line for line in lines)
    corners, end = [], 0
    while found := _TEXT.match(text, end):
        end = found.end()
        words = found[1].split()
        if len(words) != 12:
            raise InputError(f"facet {len(corners) // 3 + 1} has {len(words) // 4} corners, three are needed")
        try:
            corners += [numbers(words[first + 1:first + 4]) for first in (0, 4, 8)]
        except ValueError as error:
            raise unreadable("STL", f"facet {len(corners) // 3 + 1}: {error}") from error
    if text[end:].strip():
        line = text.count("\n", 0, len(text) - len(text[end:].lstrip())) + 1
        raise unreadable("STL", f"line {line}: {lines[line - 1].strip()!r:.60} begins no facet that is complete")
    return np.array(corners, dtype=np.float64).reshape(-1, 3)
