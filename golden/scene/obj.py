"""Reader of Wavefront OBJ files: polygons with their materials.

Polygons are read whole: loaders of triangles cut a polygon into a fan, and the fan of a concave polygon covers area
outside of it.
"""

from pathlib import Path

import numpy as np

from golden.errors import InputError
from golden.input_warnings import warn
from golden.scene.appearance import UNSPECIFIED, colour_materials
from golden.scene.mesh import Mesh
from golden.scene.mtl import MtlMaterial, read_mtl
from golden.scene.parser import check_regular
from golden.scene.texture import join_halves
from golden.scene.textures import FaceTextures
from golden.scene.unused import Unused

__all__ = ["read_obj"]

# Creases decide about smoothness (`golden.scene.mesh.mesh_scene`), not the normals of a file; groups are names.
SKIPPED = ("vn", "g", "o", "s")

class _Obj:
    """The state of the reader between lines."""

    def __init__(self, path: Path):
        self.path = path
        self.points: list[list[float]] = []
        self.uv: list[list[float]] = []
        self.uv_corners: list[int] = []
        self.counts: list[int] = []
        self.corners: list[int] = []
        self.material: list[int] = []
        self.library: dict = {}
        self.files: list[Path] = []
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

    def texture_vertex(self, words: list[str]) -> None:
        """Reads texture coordinates; the second one may be missing."""
        try:
            self.uv.append([float(word) for word in [*words, "0"][:2]])
        except ValueError:
            raise self.error(f"{' '.join(words)!r} is not a pair of texture coordinates") from None

    def _texture_corner(self, word: str) -> int:
        """The number of a corner's texture coordinates, or -1 if it states none."""
        text = word.split("/")[1] if "/" in word else ""
        if not text:
            return -1
        count = len(self.uv)
        try:
            number = int(text)
        except ValueError:
            raise self.error(f"{word!r} is not a corner of a face") from None
        if not (1 <= number <= count or -count <= number <= -1):
            raise self.error(f"face {len(self.counts) + 1} has texture coordinates {number}, "
                             f"but there are {count} so far")
        return number - 1 if number > 0 else count + number

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
            self.uv_corners.append(self._texture_corner(word))
        self.counts.append(len(words))
        self.material.append(self.numbers.setdefault(self.current, len(self.numbers)))

    def use(self, name: str) -> None:
        """Sets the material of the faces that follow."""
        if name not in self.library and self.lost:
            self.library[name] = MtlMaterial("unspecified", {})
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
                text = path.read_text(encoding="utf-8-sig", errors="replace")
            except FileNotFoundError:
                self.lost = True
                warn(f"there is no material library {name!r}: its materials become grey")
                continue
            except (OSError, ValueError) as error:  # a ValueError for a name with a zero byte
                reason = getattr(error, "strerror", None) or error
                raise self.error(f"material library {name!r} cannot be read ({reason})") from error
            self.files.append(path)
            try:
                found = read_mtl(text, where=name, folder=path.parent)
                self.library.update(found)
                self.files += [one.picture for one in found.values() if one.picture is not None]
            except InputError as error:
                raise self.error(str(error)) from error


def read_obj(path: Path) -> Mesh:
    """The mesh of an OBJ file.

    Vertices, texture coordinates, faces (also with negative numbers), ``mtllib`` and ``usemtl`` are read; normals,
    groups, lines, points and free-form surfaces are skipped. Pictures reflect diffusely point by point
    (`golden.scene.textures.Textures`). Faces are two-sided: OBJ does not define sides. The materials of a library that
    does not exist are `UNSPECIFIED`.

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
        Names what is skipped, but for normals and groups; a library that does not exist.
    """
    obj = _Obj(path)
    text = path.read_text(encoding="utf-8-sig", errors="replace")
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
        elif words[0] == "vt":
            obj.texture_vertex(words[1:])
        elif words[0] in ("f", "fo"):
            obj.face(words[1:])
        elif words[0] == "usemtl":
            obj.use(" ".join(words[1:]))
        elif words[0] == "mtllib":
            obj.libraries(line)
        elif words[0] not in SKIPPED:
            obj.unused.add(f"{words[0]!r}")
    points = np.array(obj.points, dtype=np.float64).reshape(-1, 3)
    counts, corners = np.array(obj.counts, dtype=np.int64), np.array(obj.corners, dtype=np.int64)
    textures = FaceTextures()
    materials, material = _materials(obj, points, counts, corners, textures)
    textures.add_unused(obj.unused)
    obj.unused.warn()
    return Mesh(points=points, counts=counts, corners=corners, material=material, materials=tuple(materials),
                one_sided=np.zeros(len(materials), dtype=bool), textures=textures.build(len(counts)),
                files=tuple(obj.files))


def _materials(obj: _Obj, points, counts, corners, textures) -> tuple[list, np.ndarray]:
    """The materials, with a tint for each different mean of a picture over a face, and F indices into them."""
    stated = np.array(obj.material, dtype=np.int64)
    material, materials = np.empty(len(counts), dtype=np.int64), []
    for number, name in enumerate(obj.numbers):
        faces = np.flatnonzero(stated == number)
        source = None if name is None else obj.library[name]
        if source is None or source.texture is None:
            material[faces] = len(materials)
            materials.append(UNSPECIFIED if source is None else source.material())
            continue
        colours, has_uv = _colours(obj, source.texture, faces, counts)
        obj.unused.add("texture of a face without coordinates", int((~has_uv).sum()))
        if (counts[faces] == 3).all():
            starts = (np.cumsum(counts) - counts)[faces]
            colours = join_halves(points[corners[starts[:, None] + np.arange(3)]], colours)
        tints, index = colour_materials(colours)
        if has_uv.any():
            _paint(textures, source.texture, obj, faces[has_uv], points, counts, corners,
                   np.array([tint.diffuse for tint in tints])[index[has_uv]])
        material[faces] = len(materials) + index
        materials += [source.material(np.array(tint.diffuse), name=name if len(tints) == 1 else f"{name} {tint.name}")
                      for tint in tints]
    return materials, material


def _paint(textures, texture, obj, faces, points, counts, corners, colour):
    """Puts a picture on faces, all of whose corners have texture coordinates."""
    number = counts[faces]
    first = (np.cumsum(counts) - counts)[faces]
    picks = np.repeat(first, number) + np.arange(number.sum()) - np.repeat(np.cumsum(number) - number, number)
    textures.add(texture, faces, points=points[corners[picks]], uv=np.array(obj.uv)[np.array(obj.uv_corners)[picks]],
                 counts=number, colour=colour)


def _colours(obj: _Obj, texture, faces, counts) -> tuple[np.ndarray, np.ndarray]:
    """K x 3 means of a picture over faces, the whole picture's where a corner has no coordinates, and who has some."""
    starts = np.cumsum(counts) - counts
    numbers = np.array(obj.uv_corners, dtype=np.int64)
    # Fans of triangles; of a concave polygon the parts that they add and subtract have signs.
    fans = counts[faces] - 2
    owner = np.repeat(np.arange(len(faces)), fans)
    rank = np.arange(len(owner)) - np.repeat(np.cumsum(fans) - fans, fans)
    picks = starts[faces][owner, None] + np.stack([0 * rank, rank + 1, rank + 2], axis=1)
    chosen = numbers[picks]
    has_uv = np.bincount(owner, (chosen < 0).any(axis=1), len(faces)) == 0
    uv = np.array(obj.uv, dtype=np.float64).reshape(-1, 2)
    known = has_uv[owner]
    colours = np.empty((len(faces), 3))
    if not has_uv.all():
        colours[~has_uv] = texture.mean()
    if known.any():
        corners = uv[chosen[known]]
        along, up = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        signed = along[:, 0] * up[:, 1] - along[:, 1] * up[:, 0]
        total = np.bincount(owner[known], signed, len(faces))
        weight = np.where(total[owner[known]] == 0, 1.0, signed * np.sign(total[owner[known]]))
        means = texture.means(corners)
        total = np.bincount(owner[known], weight, len(faces))
        sums = np.stack([np.bincount(owner[known], weight * channel, len(faces)) for channel in means.T], axis=1)
        colours[has_uv] = np.clip(sums[has_uv] / total[has_uv, None], 0, 1)
    return colours, has_uv
