"""Reader of STL files, binary and text."""

import re
from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.scene.appearance import UNSPECIFIED
from golden.scene.face_normals import contradicted
from golden.scene.file_text import lines_of, numbers
from golden.scene.mesh import Mesh
from golden.scene.parser import unreadable
from golden.scene.unused import NORMALS, Unused

__all__ = ["read_stl"]

_HEAD, _FACET = 84, 50
# A solid's name ends with its line and may hold any words.
_SOLID = re.compile(r"\s*(end\s*)?solid\b.*", re.IGNORECASE)
_TEXT = re.compile(r"\s*+facet\s++normal((?:\s++\S++){3})\s++outer\s++loop((?:\s++vertex(?:\s++\S++){3})*+)\s++"
                   r"end\s*+loop\s++end\s*+facet(?=\s|$)", re.IGNORECASE)


def read_stl(path: Path) -> Mesh:
    """The mesh of an STL file. Faces are two-sided, of one grey; their normals follow from the order of corners.

    Raises
    ------
    InputError
        The file is no STL file, ends too early or has facets of more than three corners; the message lacks the path.
    OSError
        The file cannot be read.

    Warns
    -----
    InputWarning
        Names attributes of facets, bytes behind the last one, and normals that contradict the order of corners.
    """
    data = path.read_bytes()
    expected = _HEAD + _FACET * int.from_bytes(data[80:_HEAD], "little")
    # Programs append less than a facet.
    is_binary = len(data) >= _HEAD and 0 <= len(data) - expected < _FACET
    unused = Unused()
    points, normals = _binary(data, expected, unused) if is_binary else _text(data, expected)
    count = len(points) // 3
    counts, corners = np.full(count, 3), np.arange(3 * count)
    unused.add(NORMALS, contradicted(points, counts, corners, np.repeat(normals, 3, axis=0)))
    unused.warn()
    return Mesh(points=points, counts=counts, corners=corners,
                material=np.zeros(count, dtype=np.int64), materials=(UNSPECIFIED,), one_sided=np.zeros(1, dtype=bool))


def _binary(data, expected, unused):
    """The vertices of the facets, three of each, and their normals."""
    facets = np.frombuffer(data[_HEAD:expected], dtype=[("numbers", "<f4", (4, 3)), ("attribute", "<u2")])
    unused.add("attributes of facets", bool(facets["attribute"].any()))
    unused.add("bytes behind the last facet", len(data) - expected)
    numbers = facets["numbers"].astype(np.float64)
    return numbers[:, 1:].reshape(-1, 3), numbers[:, 0]


def _text(data, expected):
    lines = lines_of(data)
    if not data.strip():
        return np.empty((0, 3)), np.empty((0, 3))
    if any("\0" in line for line in lines) or not _SOLID.match(next((line for line in lines if line.strip()), "")):
        raise unreadable("STL", f"it is {len(data)} bytes long and should be {expected}" if len(data) >= _HEAD
                         else "it begins neither with a header of 84 bytes nor with 'solid'")
    text = "\n".join("" if _SOLID.match(line) else line for line in lines)
    corners, normals, end = [], [], 0
    while found := _TEXT.match(text, end):
        end = found.end()
        words = found[2].split()
        if len(words) != 12:
            raise InputError(f"facet {len(corners) // 3 + 1} has {len(words) // 4} corners, three are needed")
        try:
            corners += [numbers(words[first + 1:first + 4]) for first in (0, 4, 8)]
        except ValueError as error:
            raise unreadable("STL", f"facet {len(corners) // 3 + 1}: {error}") from error
        normals.append(_normal(found[1].split()))
    if text[end:].strip():
        line = text.count("\n", 0, len(text) - len(text[end:].lstrip())) + 1
        raise unreadable("STL", f"line {line}: {lines[line - 1].strip()!r:.60} begins no facet that is complete")
    return (np.array(values, dtype=np.float64).reshape(-1, 3) for values in (corners, normals))


def _normal(words):
    """Three numbers, 0 of words that are none: only the corners count."""
    try:
        return numbers(words)
    except ValueError:
        return [0.0, 0.0, 0.0]
