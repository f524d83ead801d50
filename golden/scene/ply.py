"""Reader of PLY files: polygons with vertex or face colours.

An own reader because polygons have to arrive whole, in binary files with faces of different sizes too.
"""

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.scene.appearance import UNSPECIFIED, colour_materials, from_srgb
from golden.scene.face_normals import contradicted
from golden.scene.file_text import lines_of
from golden.scene.mesh import Mesh
from golden.scene.unused import NORMALS, Unused

__all__ = ["read_ply"]

TYPES = {"char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
         "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4", "float32": "f4",
         "double": "f8", "float64": "f8"}
ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}
CORNERS = ("vertex_indices", "vertex_index")
COLOURS = ("red", "green", "blue")
NORMAL = ("nx", "ny", "nz")
LONGEST_WORD = 64
"""Most characters of a number in text that are read."""

Kind = tuple[str, int]
"""A type of numbers, and how many of them follow one another."""


@dataclass
class _Element:
    """``count`` rows of properties: name, type, and the type of the length of a list.

    ``columns``: by name, the values of all rows; of a list its lengths and its values, row after row.
    """

    name: str
    count: int
    properties: list[tuple[str, str, str | None]] = field(default_factory=list)
    columns: dict = field(default_factory=dict)

    def add(self, name: str, kind: str, length_kind: str | None) -> None:
        """Adds a property; ValueError if there is one of that name."""
        if any(name == known for known, _, _ in self.properties):
            raise ValueError
        self.properties.append((name, kind, length_kind))

    def has_numbers(self, names: tuple[str, ...]) -> bool:
        """Whether all of these properties are there and none is a list."""
        return all(isinstance(self.columns.get(name), np.ndarray) for name in names)


def _header(data: bytes, where: str) -> tuple[str, list[_Element], int]:
    """Byte order ('' for text), elements, and the offset of their rows."""
    # Rows begin behind one end of a line; the first line shows which one, as a row may begin with its bytes.
    start = re.match(rb"ply[ \t]*(\r\n|\r|\n)", data)
    end = start and re.compile(rb"(?<=[\r\n])end_header[ \t]*(" + start[1] + rb"|\r?\n|$)").search(data)
    if not end:
        raise InputError(f"{where}: not a PLY file")
    order, elements = None, []
    for number, line in enumerate(lines_of(data[:end.start()]), start=1):
        words = line.split()
        try:
            if words[:1] == ["format"]:
                order = ORDERS[words[1]]
            elif words[:1] == ["element"]:
                if any(words[1] == known.name for known in elements):
                    raise ValueError
                elements.append(_Element(words[1], int(words[2])))
            elif words[:2] == ["property", "list"]:
                elements[-1].add(words[4], TYPES[words[3]], TYPES[words[2]])
            elif words[:1] == ["property"]:
                elements[-1].add(words[2], TYPES[words[1]], None)
            elif words and words[0] not in ("comment", "obj_info") and words != ["ply"]:
                raise ValueError
        except (KeyError, IndexError, ValueError):
            raise InputError(f"{where}:{number}: {line.strip()!r} is not a PLY header line") from None
    if order is None or any(element.count < 0 for element in elements):
        raise InputError(f"{where}: not a PLY file")
    return order, elements, end.end()


class _Text:
    """Rows of numbers in text: every value is a word; ``position`` is the number of the next one."""

    def __init__(self, data: bytes):
        words = data.split()
        # An array of words takes the longest one's memory for each.
        self._words = np.array(words if max(map(len, words), default=0) <= LONGEST_WORD
                               else [word if len(word) <= LONGEST_WORD else b"?" for word in words])
        self._has_separators = b"_" in data
        self.position = 0

    @property
    def left(self) -> int:
        """Upper bound of the values to come."""
        return len(self._words) - self.position

    def rows(self, kinds: list[Kind], count: int) -> list[np.ndarray]:
        """``count`` rows of values, a column each; EOFError if there are fewer, ValueError if one is no number."""
        ends = np.cumsum([length for _, length in kinds])
        end = self.position + count * int(ends[-1])
        if end > len(self._words):
            raise EOFError
        table = self._words[self.position:end].reshape(count, int(ends[-1]))
        self.position = end
        if self._has_separators and (np.char.find(table, b"_") >= 0).any():
            raise ValueError  # Python's own digit separators
        return [table[:, stop - length:stop].astype(np.float64) for (_, length), stop in zip(
            kinds, ends.tolist(), strict=True)]

    def peek(self, kind: str, skip: list[Kind]) -> int:
        """The value after the next ones, which are of the types ``skip``; ValueError if it is not whole."""
        position = self.position + sum(length for _, length in skip)
        if position >= len(self._words):
            raise EOFError
        return int(self._words[position])


class _Binary:
    """Rows of numbers in binary; ``position`` is the offset of the next one."""

    def __init__(self, data: bytes, order: str):
        self._data, self._order, self.position = data, order, 0

    def _dtype(self, kinds):
        return np.dtype([(f"f{column}", self._order + kind, (length,)) for column, (kind, length) in enumerate(kinds)])

    @property
    def left(self) -> int:
        """Upper bound of the values to come."""
        return len(self._data) - self.position

    def rows(self, kinds: list[Kind], count: int) -> list[np.ndarray]:
        """``count`` rows of values of the given types, a column each; EOFError if there are fewer."""
        dtype = self._dtype(kinds)
        end = self.position + count * dtype.itemsize
        if end > len(self._data):
            raise EOFError
        table = np.frombuffer(self._data, dtype, count, self.position) if count else np.empty(0, dtype)
        self.position = end
        return [table[name] for name in dtype.names]

    def peek(self, kind: str, skip: list[Kind]) -> int:
        """The value after the next ones, which are of the types ``skip``; ValueError if it is not whole."""
        offset = self.position + self._dtype(skip).itemsize
        item = np.dtype(self._order + kind)
        if offset + item.itemsize > len(self._data):
            raise EOFError
        value = np.frombuffer(self._data, item, 1, offset)[0]
        if value != int(value):
            raise ValueError
        return int(value)


def _typed(values: np.ndarray, kind: str) -> np.ndarray:
    """Values as numbers of a type; ValueError if one is none."""
    if kind[0] == "f" or values.dtype.kind != "f":
        return values
    limits = np.iinfo(kind)
    if not ((values >= limits.min) & (values <= limits.max) & (values == np.floor(values))).all():
        raise ValueError
    return values.astype(np.int64)


def _run(rows, element: _Element, left: int) -> tuple[int, list[int], list[np.ndarray]]:
    """Reads all rows up to the first whose lists have other lengths than the next row's, in doubling steps.

    Returns
    -------
    tuple
        The number of rows, the lengths of their lists, and for each number or list of a row its values, rows x length.
    """
    kinds: list[Kind] = []
    lengths = []
    for _, kind, length_kind in element.properties:
        if length_kind:
            lengths.append((len(kinds), rows.peek(length_kind, kinds)))
            if not 0 <= lengths[-1][1] <= rows.left:
                raise EOFError
            kinds += [(length_kind, 1), (kind, lengths[-1][1])]
        else:
            kinds.append((kind, 1))
    start, step = rows.position, 8
    while True:
        count = min(step, left)
        rows.position = start
        try:
            table = rows.rows(kinds, count)
        except EOFError:
            if count == 1:
                raise
            # Later rows may be shorter.
            step = max(1, count // 2)
            left = min(left, step)
            continue
        same = np.ones(count, dtype=bool)
        for column, length in lengths:
            same &= table[column][:, 0] == length
        good = count if same.all() else int(same.argmin())
        if good < count or count == left:
            break
        step *= 2
    rows.position = start
    table = [_typed(column, kind) for column, (kind, _) in zip(rows.rows(kinds, good), kinds, strict=True)]
    return good, [length for _, length in lengths], table


def _read_lists(rows, element: _Element) -> None:
    """Fills the columns of an element."""
    parts: dict[str, list] = {name: [(np.empty(0, np.int64), np.empty(0, kind)) if length_kind else np.empty(0, kind)]
                              for name, kind, length_kind in element.properties}
    # Rows without properties are empty, however many the file claims.
    left = element.count if element.properties else 0
    if left > rows.left:
        raise EOFError
    while left:
        count, lengths, table = _run(rows, element, left)
        left -= count
        column, lengths = 0, iter(lengths)
        for name, _, length_kind in element.properties:
            if length_kind:
                parts[name].append((np.full(count, next(lengths)), table[column + 1].reshape(-1)))
                column += 2
            else:
                parts[name].append(table[column][:, 0])
                column += 1
    for name, _, length_kind in element.properties:
        element.columns[name] = (tuple(map(np.concatenate, zip(*parts[name], strict=True))) if length_kind
                                 else np.concatenate(parts[name]))


def _colours(element: _Element, unused: Unused) -> np.ndarray | None:
    """N x 3 linear colours, None if the element has none: integers are sRGB over their full range, floats linear."""
    kinds = {name: kind for name, kind, _ in element.properties}
    if not element.has_numbers(COLOURS):
        return None
    columns = []
    for name in COLOURS:
        values, is_linear = element.columns[name].astype(np.float64), kinds[name][0] == "f"
        values = values if is_linear else values / np.iinfo(kinds[name]).max
        unused.add("colours beyond 0 to 1", int((~((values >= 0) & (values <= 1))).sum()))
        values = np.clip(np.nan_to_num(values), 0, 1)
        columns.append(values if is_linear else from_srgb(values))
    return np.stack(columns, axis=1)


def _add_unused(unused: Unused, elements: list[_Element], *, used: dict[str, tuple[str, ...]]) -> None:
    for element in elements:
        if element.count and element.name not in used:
            unused.add(f"element {element.name}")
        elif element.count:
            for name, _, _ in element.properties:
                unused.add(f"{element.name} property {name}", name not in used[element.name])


def _corner_lists(element: _Element) -> tuple[str, tuple[np.ndarray, np.ndarray] | None]:
    """The property that has the lists of corners, and their lengths and corners; None if there is none."""
    for name in CORNERS:
        if isinstance(element.columns.get(name), tuple):
            return name, element.columns[name]
    return "", None


def _strips(counts: np.ndarray, corners: np.ndarray, unused: Unused) -> np.ndarray:
    """T x 3 corners of the triangles of strips, which -1 parts; every other one is wound the other way."""
    begins = np.zeros(len(corners), dtype=bool)
    begins[(np.cumsum(counts) - counts)[counts > 0]] = True
    begins[1:] |= corners[:-1] == -1
    part = np.cumsum(begins) - 1
    first = np.flatnonzero((part[:-2] == part[2:]) & (corners[:-2] != -1) & (corners[2:] != -1))
    sizes = np.bincount(part[corners != -1], minlength=1)
    unused.add("corners of an incomplete triangle", int(sizes[sizes < 3].sum()))
    odd = (first - np.flatnonzero(begins)[part[first]]) % 2
    triangles = corners[np.stack((first + odd, first + 1 - odd, first + 2), axis=1)]
    # Triangles with a corner twice only join parts of a strip.
    return triangles[(triangles != np.roll(triangles, 1, axis=1)).all(axis=1)]


def read_ply(path: Path) -> Mesh:
    """The mesh of a PLY file, text or binary.

    The diffuse reflectance of a face is its colour, or the mean of its corners' colours, rounded to 8-bit sRGB.
    Integers are sRGB, floats linear. Faces are two-sided: PLY does not define sides. The triangles of ``tristrips``
    follow the faces.

    Raises
    ------
    InputError
        The file is no PLY file, ends too early, has no faces or no vertices, or a value is not a number of its type.
    OSError
        The file cannot be read.

    Warns
    -----
    InputWarning
        Names elements and properties that are not used, but for normals that agree with the order of corners, and what
        follows the last row.
    """
    data, where = path.read_bytes(), str(path)
    order, elements, body = _header(data, where)
    rows = _Binary(data[body:], order) if order else _Text(data[body:])
    for element in elements:
        try:
            _read_lists(rows, element)
        except EOFError:
            raise InputError(f"{where}: it ends within its {element.count} {element.name} rows") from None
        except (ValueError, OverflowError):
            raise InputError(f"{where}: a value in its {element.name} rows is not a number of its type") from None
    unused = Unused()
    unused.add(f"{'bytes' if order else 'words'} behind the last row", rows.left)
    named = {element.name: element for element in elements}
    vertex, face, strips = (named.get(name, _Element(name, 0)) for name in ("vertex", "face", "tristrips"))
    used, lists = _corner_lists(face)
    used_of_strips, strip_lists = _corner_lists(strips)
    counts, corners = (side.astype(np.int64) for side in lists or (np.empty(0), np.empty(0)))
    if strip_lists is not None:
        triangles = _strips(*(side.astype(np.int64) for side in strip_lists), unused)
        counts = np.append(counts, np.full(len(triangles), 3))
        corners = np.append(corners, triangles)
    if not len(counts):
        raise InputError(f"{where}: it has no faces")
    if not vertex.has_numbers(("x", "y", "z")):
        raise InputError(f"{where}: its vertices have no x, y, z")
    if not vertex.count:
        raise InputError(f"{where}: it has no vertices")
    points = np.stack([vertex.columns[name] for name in "xyz"], axis=1).astype(np.float64)
    colours = _colours(face, unused) if face.count == len(counts) else None
    at_vertices = colours is None and vertex.has_numbers(COLOURS)
    _add_unused(unused, elements, used={"face": (used, *(COLOURS if colours is not None else ())),
                                        "tristrips": (used_of_strips,),
                                        "vertex": ("x", "y", "z", *NORMAL, *(COLOURS if at_vertices else ()))})
    colours_of_vertices = _colours(vertex, unused) if at_vertices else None
    # `mesh_scene` refuses corners at vertices that do not exist.
    existing = np.clip(corners, 0, len(points) - 1)
    if vertex.has_numbers(NORMAL):
        normals = np.stack([vertex.columns[name] for name in NORMAL], axis=1).astype(np.float64)
        unused.add(NORMALS, contradicted(points, counts, corners, normals[existing]))
    unused.warn()
    if at_vertices and counts.all():
        at_corners = colours_of_vertices[existing]
        colours = np.add.reduceat(at_corners, np.cumsum(counts) - counts, axis=0) / counts[:, None]
    if colours is None:
        materials, material = (UNSPECIFIED,), np.zeros(len(counts), dtype=np.int64)
    else:
        materials, material = colour_materials(colours)
    return Mesh(points=points, counts=counts, corners=corners, material=material, materials=materials,
                one_sided=np.zeros(len(materials), dtype=bool))
