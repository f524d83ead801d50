"""Reader of Wavefront OBJ files: polygons with their materials.

Polygons are read whole: loaders of triangles cut a polygon into a fan, and the fan of a concave polygon covers area
outside of it.
"""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.base.input_warnings import warn
from golden.scene.appearance import UNSPECIFIED, colour_materials
from golden.scene.face_normals import contradicted
from golden.scene.file_text import file_of, forms_of, lines_of, numbers, unquoted
from golden.scene.mesh import Mesh
from golden.scene.mtl import MtlMaterial, read_mtl
from golden.scene.parser import check_regular
from golden.scene.texture import join_halves
from golden.scene.textures import FaceTextures
from golden.scene.unused import NORMALS, Unused

__all__ = ["read_obj"]

# Creases decide about smoothness (`golden.scene.mesh.mesh_scene`); groups are names.
SKIPPED = ("g", "o", "s")
# Statements of one name, which may hold any character and end in a backslash; mtllib may be continued in the next line.
# In the other statements # begins a comment.
NAMES = ("usemtl", "g", "o")
NAMED = ("mtllib", *NAMES)


def _statements(lines: list[str]) -> Iterator[tuple[int, str, str]]:
    """Yields each statement: number of its last line, keyword, and what follows it, without comments."""
    parts: list[str] = []
    for number, line in enumerate(lines, start=1):
        text, continues = line, False
        if "#" in line:
            is_comment = line.lstrip().startswith("#")
            if is_comment or "".join(parts[:1] or line).split(None, 1)[0] not in NAMED:
                text = re.split(r"(?:^|\s)#", line, maxsplit=1)[0]
                continues = is_comment and bool(parts) and number < len(lines)  # it stands within a statement
        if text is line and "\\" in line and line.rstrip().endswith("\\") and (
                parts or line.split(None, 1)[0] not in NAMES):
            text, continues = line.rstrip()[:-1], number < len(lines)
        if parts or (text and not text.isspace()):
            parts.append(text)
        if parts and not continues:
            keyword, *rest = " ".join(parts).split(None, 1) or [""]
            parts = []
            if keyword:
                yield number, keyword, rest[0].rstrip() if rest else ""


class _Obj:
    """The state of the reader between lines."""

    def __init__(self, path: Path):
        self.path = path
        self.points: list[list[float]] = []
        self.uv: list[list[float]] = []
        self.normals: list[list[float]] = []
        self.uv_corners: list[int] = []
        self.normal_corners: list[int] = []
        self.counts: list[int] = []
        self.corners: list[int] = []
        self.material: list[int] = []
        self.library: dict[str, MtlMaterial] = {}
        self.files: list[Path] = []
        self.unused = Unused()
        self.numbers: dict[str, int] = {}
        self._current = ""
        self._read: set[Path] = set()
        self._lost: list[str] = []
        self.where = str(path)

    def error(self, what: str) -> InputError:
        """An error at the current line."""
        return InputError(f"{self.where}: {what}")

    def vertex(self, text: str) -> None:
        """Reads a vertex."""
        try:
            values = numbers(text.split())
        except ValueError:
            values = []
        if len(values) < 3:
            raise self.error(f"{text!r} is not a vertex")
        point = values[:3]
        if not all(abs(value) < np.inf for value in point):
            raise self.error(f"vertex {len(self.points) + 1} is not finite: {text}")
        self.points.append(point)
        self.unused.add("colours of vertices", len(values) >= 6)
        self.unused.add("weights of vertices", len(values) in (4, 5) and values[3] != 1)

    def texture_vertex(self, text: str) -> None:
        """Reads texture coordinates; the second one may be missing."""
        try:
            values = numbers(text.split())
            self.uv.append([values[0], *values[1:2], 0.0][:2])
        except (ValueError, IndexError):
            raise self.error(f"{text!r} is not a pair of texture coordinates") from None
        self.unused.add("third texture coordinates", any(values[2:]))

    def normal(self, text: str) -> None:
        """Reads a normal; one that is no three numbers contradicts nothing."""
        try:
            values = numbers(text.split())
        except ValueError:
            values = []
        self.normals.append(values[:3] if len(values) >= 3 else [0.0, 0.0, 0.0])

    def _normal_corner(self, word: str) -> int:
        """The number of a corner's normal, or -1 if it states none or one that does not exist."""
        text, count = word.split("/")[2] if word.count("/") == 2 else "", len(self.normals)
        number = self._number(word, text) if text else 0
        if not (1 <= number <= count or -count <= number <= -1):
            self.unused.add("normals of corners that do not exist", number != 0)
            return -1
        return number - 1 if number > 0 else count + number

    def _number(self, word: str, text: str) -> int:
        """A whole number of a corner."""
        try:
            if "_" in text:
                raise ValueError
            return int(text)
        except ValueError:
            raise self.error(f"{word!r} is not a corner of a face") from None

    def _texture_corner(self, word: str) -> int:
        """The number of a corner's texture coordinates, or -1 if it states none."""
        text = word.split("/")[1] if "/" in word else ""
        if not text:
            return -1
        count, number = len(self.uv), self._number(word, text)
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
            number = self._number(word, word.partition("/")[0])
            if not (1 <= number <= count or -count <= number <= -1):
                raise self.error(f"face {len(self.counts) + 1} has a corner at vertex {number}, "
                                 f"but there are {count} vertices so far")
            self.corners.append(number - 1 if number > 0 else count + number)
            self.uv_corners.append(self._texture_corner(word))
            self.normal_corners.append(self._normal_corner(word))
        self.counts.append(len(words))
        self.material.append(self.numbers.setdefault(self._current, len(self.numbers)))

    def use(self, name: str) -> None:
        """Sets the material of the faces that follow; without a name they have none."""
        self._current = name

    def sources(self) -> list[MtlMaterial | None]:
        """The materials that faces name, in the order of their numbers; None of faces without one.

        Names count wherever the libraries are named. What is in none of them may be in the library with the name of the
        file, which is used with a warning. A material that is nowhere is unspecified, with a warning.
        """
        found = self._found()
        missing = [name for name, known in found.items() if name and known is None]
        own = self.path.with_suffix(".mtl")
        if missing and own not in self._read and own.is_file():
            warn(f"material library {own.name!r}, which is not named, is used for {missing[0]!r}{_more(missing)}")
            self._lost.clear()
            self.where = str(self.path)
            self._library(own.name, own)
            found = self._found()
            missing = [name for name in missing if found[name] is None]
        if self._lost:
            their = ": its" if len(self._lost) == 1 else f"{_more(self._lost)}: their"
            warn(f"there is no material library {self._lost[0]!r}{their} materials become grey")
        elif missing:
            warn(f"there is no material {missing[0]!r}{_more(missing)}: faces of it become grey")
        for name, known in found.items():
            if known is not None and unquoted(name) != unquoted(known):
                warn(f"material {name!r} is taken for {known!r}")
        return [self.library.get(known, MtlMaterial("unspecified", {}) if name else None)
                for name, known in found.items()]

    def _found(self):
        """By the names that faces use those of the libraries, or None."""
        aliases = {}
        for name in self.library:
            for form in forms_of(name):
                aliases.setdefault(form, name)
        return {name: next((form if form in self.library else aliases[form] for form in forms_of(name)
                            if form in aliases), None) for name in self.numbers}

    def libraries(self, text: str) -> None:
        """Reads the material libraries of a line; a name may hold blanks, and quotes around it."""
        whole = file_of(self.path.parent, forms_of(text))
        for name in [whole[1]] if whole else [quoted or word for quoted, word in re.findall(
                r'"([^"]+)"|(\S+)', re.split(r"(?:^|\s)#", text, maxsplit=1)[0])]:
            path, _ = whole or file_of(self.path.parent, [name]) or (self.path.parent / name.replace("\\", "/"), name)
            if path not in self._read:
                self._read.add(path)
                self._library(name, path)

    def _library(self, name, path):
        try:
            check_regular(path)
            data = path.read_bytes()
        except FileNotFoundError:
            self._lost.append(name)
            return
        except InputError:
            raise
        except (OSError, ValueError) as error:  # a ValueError for a name with a zero byte
            reason = getattr(error, "strerror", None) or error
            raise self.error(f"material library {name!r} cannot be read ({reason})") from error
        self.files.append(path)
        try:
            found = read_mtl(data, where=name, folder=path.parent)
        except InputError as error:
            raise self.error(str(error)) from error
        # The first of several libraries that has a material counts.
        again = self.library.keys() & found
        self.unused.add("material of a further library with the name of an earlier one", len(again))
        self.library = found | self.library
        self.files += [one.picture for one in found.values() if one.picture is not None]


def _more(names):
    """How many there are beside the first one."""
    return f" and {len(names) - 1} more" if len(names) > 1 else ""


def read_obj(path: Path) -> Mesh:
    """The mesh of an OBJ file.

    Vertices, texture coordinates, faces (also with negative numbers), ``mtllib`` and ``usemtl`` are read; groups,
    lines, points and free-form surfaces are skipped. Pictures reflect diffusely point by point
    (`golden.scene.textures.Textures`). Faces are two-sided: OBJ does not define sides. Their front is that of the order
    of corners. Materials that are nowhere are `UNSPECIFIED`.

    Raises
    ------
    InputError
        With path and line: a vertex or corner that is no number, a vertex that is not finite, a face at a vertex that
        is not defined before it.
    OSError
        The file cannot be read.

    Warns
    -----
    InputWarning
        Names what is skipped, but for groups; normals that contradict the order of corners; libraries and materials
        that do not exist.
    """
    obj = _Obj(path)
    for number, keyword, text in _statements(lines_of(path.read_bytes())):
        obj.where = f"{path}:{number}"
        if keyword == "v":
            obj.vertex(text)
        elif keyword == "vt":
            obj.texture_vertex(text)
        elif keyword == "vn":
            obj.normal(text)
        elif keyword in ("f", "fo"):
            obj.face(text.split())
        elif keyword == "usemtl":
            obj.use(text)
        elif keyword == "mtllib":
            obj.libraries(text)
        elif keyword not in SKIPPED:
            obj.unused.add(f"{keyword!r}")
    points = np.array(obj.points, dtype=np.float64).reshape(-1, 3)
    counts, corners = np.array(obj.counts, dtype=np.int64), np.array(obj.corners, dtype=np.int64)
    if obj.normals:
        # What is no number of a normal is that of the last one, 0.
        normals = np.array([*obj.normals, (0, 0, 0)], dtype=np.float64)
        obj.unused.add(NORMALS, contradicted(points, counts, corners, normals[obj.normal_corners]))
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
    groups = np.split(np.argsort(stated, kind="stable"), np.cumsum(np.bincount(stated))[:-1])
    for name, source, faces in zip(obj.numbers, obj.sources(), groups if len(stated) else [], strict=True):
        if source is None or source.texture is None:
            material[faces] = len(materials)
            materials.append(UNSPECIFIED if source is None else source.material())
            continue
        colours, has_uv = _colours(obj, source, faces, counts)
        obj.unused.add("texture of a face without coordinates", int((~has_uv).sum()))
        if (counts[faces] == 3).all():
            starts = (np.cumsum(counts) - counts)[faces]
            colours = join_halves(points[corners[starts[:, None] + np.arange(3)]], colours)
        tints, index = colour_materials(colours)
        if has_uv.any():
            _paint(textures, source, obj, faces[has_uv], points, counts, corners,
                   np.array([tint.diffuse for tint in tints])[index[has_uv]])
        material[faces] = len(materials) + index
        materials += [source.material(np.array(tint.diffuse), name=name if len(tints) == 1 else f"{name} {tint.name}")
                      for tint in tints]
    return materials, material


def _paint(textures, source, obj, faces, points, counts, corners, colour):
    """Puts a picture on faces, all of whose corners have texture coordinates."""
    number = counts[faces]
    first = (np.cumsum(counts) - counts)[faces]
    picks = np.repeat(first, number) + np.arange(number.sum()) - np.repeat(np.cumsum(number) - number, number)
    textures.add(source.texture, faces, points=points[corners[picks]],
                 uv=source.placed(np.array(obj.uv)[np.array(obj.uv_corners)[picks]]), counts=number, colour=colour)


def _colours(obj: _Obj, source: MtlMaterial, faces, counts) -> tuple[np.ndarray, np.ndarray]:
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
    uv = source.placed(np.array(obj.uv, dtype=np.float64).reshape(-1, 2))
    known = has_uv[owner]
    colours = np.empty((len(faces), 3))
    if not has_uv.all():
        colours[~has_uv] = source.texture.mean()
    if known.any():
        corners = uv[chosen[known]]
        along, up = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        signed = along[:, 0] * up[:, 1] - along[:, 1] * up[:, 0]
        total = np.bincount(owner[known], signed, len(faces))
        weight = np.where(total[owner[known]] == 0, 1.0, signed * np.sign(total[owner[known]]))
        means = source.texture.means(corners)
        total = np.bincount(owner[known], weight, len(faces))
        sums = np.stack([np.bincount(owner[known], weight * channel, len(faces)) for channel in means.T], axis=1)
        colours[has_uv] = np.clip(sums[has_uv] / total[has_uv, None], 0, 1)
    return colours, has_uv
