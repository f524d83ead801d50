"""Reader of View3D's input files (.vs3): vertices, and surfaces with names and emittances."""

import math
from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.scene.facet_fields import check_facets
from golden.scene.file_text import lines_of
from golden.scene.file_text import number as number_of
from golden.scene.material import Material
from golden.scene.mesh import FARTHEST
from golden.scene.scene import Scene
from golden.scene.unused import Unused

__all__ = ["read_vs3"]

_IGNORED = "T!/"
_END = "*E"


class _Vs3:
    """The state of the reader between lines."""

    def __init__(self, where: str):
        self._where = where
        self._line = 0
        self._unused = Unused()
        self._points: list[list[float]] = []
        self._corners: list[list[int]] = []
        self._material: list[int] = []
        self._materials: dict[Material, int] = {}

    def _error(self, what):
        return InputError(f"{self._where}: line {self._line}: {what}")

    def _number(self, word, what, *, whole=False):
        try:
            number = number_of(word)
            exact = int(word) if whole else number
        except ValueError:
            raise self._error(f"{what} must be a number, not {word!r}") from None
        if not math.isfinite(number):
            raise self._error(f"{what} must be finite, not {word!r}")
        if abs(number) > FARTHEST:
            raise self._error(f"{what} is beyond {FARTHEST:g}: {word}")
        return exact

    def read(self, lines: list[str]) -> None:
        """Reads all lines up to the end of the data."""
        for self._line, line in enumerate(lines, 1):
            words = line.partition("!")[0].split()
            kind = words[0][0].upper() if words else "!"
            if kind in _END:
                return
            if kind in _IGNORED:
                continue
            if kind == "C":
                self._unused.add("controls")
            elif kind == "F":
                if words[1:2] != ["3"]:
                    raise self._error(f"Geometry must be 3, not {' '.join(words[1:])!r}")
            elif kind == "V":
                self._vertex(words[1:])
            elif kind in "SO":
                self._surface(words[1:], radiates=kind == "S")
            elif kind in "MN":
                raise self._error("masks and null surfaces are not read: cut the surface behind into facets")
            else:
                raise self._error(f"{words[0]!r} begins no known entry")

    def _vertex(self, words):
        if len(words) < 4:
            raise self._error("a vertex needs a number and three coordinates")
        if self._number(words[0], "Vertex", whole=True) != len(self._points) + 1:
            raise self._error(f"vertex {words[0]} is out of sequence, {len(self._points) + 1} is next")
        self._unused.add("words behind a vertex", len(words) > 4)
        self._points.append([self._number(word, "Coordinate") for word in words[1:4]])

    def _surface(self, words, *, radiates):
        if len(words) < (8 if radiates else 5):
            raise self._error("a surface needs a number, four vertices, base, combination and emittance")
        if self._number(words[0], "Surface", whole=True) != len(self._corners) + 1:
            raise self._error(f"surface {words[0]} is out of sequence, {len(self._corners) + 1} is next")
        corners = [self._number(word, "Vertex", whole=True) for word in words[1:5]]
        for position, corner in enumerate(corners):
            if not (1 if position < 3 else 0) <= corner <= len(self._points):
                raise self._error(f"Vertex must be a number up to {len(self._points)}, not {corner}")
        if not corners[3]:
            corners[3] = corners[2]
        emittance, name = 1.0, "obstruction"
        if radiates:
            if self._number(words[5], "Base", whole=True):
                raise self._error("subsurfaces are not read: cut the base surface into facets around them")
            self._unused.add("combination of a surface", self._number(words[6], "Combination", whole=True) != 0)
            emittance = self._number(words[7], "Emittance")
            if not 0 <= emittance <= 1:
                raise self._error(f"Emittance must be 0 to 1, not {emittance:g}")
            name = " ".join(words[8:]) or words[0]
        self._corners.append(corners)
        material = Material(name=name, diffuse=(1 - emittance,) * 3)
        self._material.append(self._materials.setdefault(material, len(self._materials)))

    def scene(self, name: str) -> Scene:
        """The scene of all that was read."""
        if not self._corners:
            raise InputError(f"{self._where}: it has no surfaces")
        vertices = np.array(self._points)[np.array(self._corners) - 1]
        check_facets(vertices, self._where)
        self._unused.warn()
        return Scene(name=name, vertices=vertices, material=np.array(self._material),
                     materials=tuple(self._materials))


def read_vs3(path: Path) -> Scene:
    """The scene of a View3D file with geometry 3: patch k is surface k, and only fronts (active sides) radiate.

    A surface's name and emittance become its material, with a diffuse reflectance of 1 - emittance. Obstructions are
    patches as well, named ``obstruction``. Titles are skipped.

    Source: View3D user manual, version 3.3, section 5.

    Raises
    ------
    InputError
        With path and line: numbers that are none, not finite, out of sequence or out of range; subsurfaces, masks, null
        surfaces, another geometry; surfaces that are not planar, not strictly convex or without area.
    OSError
        The file cannot be read.

    Warns
    -----
    InputWarning
        Controls are not used, and surfaces to be combined stay separate.
    """
    reader = _Vs3(str(path))
    reader.read(lines_of(path.read_bytes()))
    return reader.scene(path.stem)
