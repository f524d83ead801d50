"""Reader of Wavefront OBJ files: polygons with their materials.

Polygons are read whole: loaders of triangles cut a polygon into a fan, and the fan of a concave polygon covers area
outside of it.
"""

import warnings
from pathlib import Path

import numpy as np

from golden.errors import InputError, InputWarning
from golden.scene.appearance import UNSPECIFIED
from golden.scene.mesh import Mesh
from golden.scene.mtl import read_mtl
from golden.scene.parser import check_regular
from golden.scene.unused import Unused

__all__ = ["read_obj"]

# Creases decide about smoothness (`golden.scene.mesh.mesh_scene`), not the normals of a file; groups are names.
SKIPPED = ("vt", "vn", "g", "o", "s")

class _Obj:
    """The state of the reader between lines."""

    def __init__(self, path: Path):
        self.path = path
        self.points: list[list[float]] = []
        self.counts: list[int] = []
        self.corners: list[int] = []
        self.material: list[int] = []
        self.library: dict = {}
        self.lost = False
        self.unused = Unused()
        self.numbers: dict[str | None, int] = {}
        self.current: str | None = None
        self.where = str(path)

    def error(self, what: str) -> InputError:
        """An error at the current line."""
        return InputError(f"{self.where}: {what}")

    def vertex(self, words: list[str]) -> None:
        """Reads a vertex."""
        try:
            point = [float(word) for word in words[:3]]
        except ValueError:
            raise self.error(f"{' '.join(words)!r} is not a vertex") from None
        if len(point) != 3:
            raise self.error(f"{' '.join(words)!r} is not a vertex")
        if not all(abs(value) < np.inf for value in point):
            raise self.error(f"vertex {len(self.points) + 1} is not finite: {' '.join(words)}")
        self.points.append(point)
        self.unused.add("colours of vertices", len(words) >= 6)

    def face(self, words: list[str]) -> None:
        """Reads a face."""
        count = len(self.points)
        if len(words) < 3:
            raise self.error(f"face {len(self.counts) + 1} has {len(words)} corners, three at least are needed")
        for word in words:
            try:
                number = int(word.partition("/")[0])
            except ValueError:
                raise self.error(f"{word!r} is not a corner of a face") from None
            if not (1 <= number <= count or -count <= number <= -1):
                raise self.error(f"face {len(self.counts) + 1} has a corner at vertex {number}, "
                                 f"but there are {count} vertices so far")
            self.corners.append(number - 1 if number > 0 else count + number)
        self.counts.append(len(words))
        self.material.append(self.numbers.setdefault(self.current, len(self.numbers)))

    def use(self, name: str) -> None:
        """Sets the material of the faces that follow."""
        if name not in self.library and self.lost:
            self.library[name] = UNSPECIFIED
        if name not in self.library:
            raise self.error(f"material {name!r} is in no material library of the file")
        self.current = name

    def libraries(self, line: str) -> None:
        """Reads the material libraries of a line; a name may hold blanks."""
        names = line.split()[1:]
        whole = line.split(None, 1)[1].strip() if names else ""
        if (self.path.parent / whole).is_file():
            names = [whole]
        for name in names:
            path = self.path.parent / name.replace("\\", "/")
            try:
                check_regular(path)
                text = path.read_text(encoding="utf-8", errors="replace")
            except FileNotFoundError:
                self.lost = True
                warnings.warn(f"there is no material library {name!r}: its materials become grey", InputWarning,
                              stacklevel=2)
                continue
            except (OSError, ValueError) as error:  # a ValueError for a name with a zero byte
                reason = getattr(error, "strerror", None) or error
                raise self.error(f"material library {name!r} cannot be read ({reason})") from error
            try:
                self.library.update(read_mtl(text, where=name, folder=path.parent))
            except InputError as error:
                raise self.error(str(error)) from error


def read_obj(path: Path) -> Mesh:
    """The mesh of an OBJ file.

    Vertices, faces (also with negative numbers), ``mtllib`` and ``usemtl`` are read; texture coordinates, normals,
    groups, lines, points and free-form surfaces are skipped. Faces are two-sided: OBJ does not define sides. The
    materials of a library that does not exist are `UNSPECIFIED`.

    Raises
    ------
    InputError
        With path and line: a vertex or corner that is no number, a vertex that is not finite, a face at a vertex that
        is not defined before it, or a material that does not exist.
    OSError
        The file cannot be read.

    Warns
    -----
    InputWarning
        Names what is skipped, but for normals, texture coordinates and groups; a library that does not exist.
    """
    obj = _Obj(path)
    text = path.read_text(encoding="utf-8", errors="replace")
    pending = ""
    for number, line in enumerate(text.splitlines(), start=1):
        if line.endswith("\\"):
            pending += line[:-1] + " "
            continue
        line, pending = (pending + line).partition("#")[0], ""
        words = line.split()
        if not words:
            continue
        obj.where = f"{path}:{number}"
        if words[0] == "v":
            obj.vertex(words[1:])
        elif words[0] in ("f", "fo"):
            obj.face(words[1:])
        elif words[0] == "usemtl":
            obj.use(" ".join(words[1:]))
        elif words[0] == "mtllib":
            obj.libraries(line)
        elif words[0] not in SKIPPED:
            obj.unused.add(f"{words[0]!r}")
    obj.unused.warn()
    materials = tuple(UNSPECIFIED if name is None else obj.library[name] for name in obj.numbers)
    return Mesh(points=np.array(obj.points, dtype=np.float64).reshape(-1, 3),
                counts=np.array(obj.counts, dtype=np.int64), corners=np.array(obj.corners, dtype=np.int64),
                material=np.array(obj.material, dtype=np.int64),
                materials=materials, one_sided=np.zeros(len(materials), dtype=bool))
