"""PLY files in drawn dialects: byte order, types of numbers and of the lengths of lists, order of what they hold."""

import struct
from dataclasses import dataclass

from hypothesis import strategies as st

__all__ = ["PlyFile", "ply_files"]

_INTEGERS = {"char": "b", "int8": "b", "uchar": "B", "uint8": "B", "short": "h", "int16": "h", "ushort": "H",
             "uint16": "H", "int": "i", "int32": "i", "uint": "I", "uint32": "I"}
_FLOATS = {"float": "f", "float32": "f", "double": "d", "float64": "d"}
_CODES = _INTEGERS | _FLOATS
_ORDERS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True)
class PlyFile:
    """The bytes of a file, its vertices, the corners of its faces and, -1 between them, of its strips, and the type and
    values of the faces' colours.
    """

    data: bytes
    points: list[tuple[float, ...]]
    faces: list[list[int]]
    strips: list[list[int]]
    colour_kind: str | None
    colours: list[tuple[float, ...]]


def _range(kind):
    """Least and largest value of a type, of floats such that all are exact."""
    if kind in _FLOATS:
        return -1024, 1024
    bits = 8 * struct.calcsize(_CODES[kind])
    return (0, 2**bits - 1) if _CODES[kind].isupper() else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)


def _values(kind):
    low, high = _range(kind)
    if kind in _FLOATS:
        return st.integers(8 * low, 8 * high).map(lambda value: value / 8)
    return st.one_of(st.sampled_from((low, high)), st.integers(low, high))


def _word(value):
    return f"{value:.9g}" if isinstance(value, float) else str(value)


@st.composite
def _others(draw, prefix):
    """Properties that a reader skips, with their kinds; lists may be empty."""
    found = []
    for number in range(draw(st.integers(0, 2))):
        kind = draw(st.sampled_from(sorted(_CODES)))
        length = draw(st.sampled_from((None, *sorted(_CODES))))
        found.append((f"{prefix}{number}", kind, length))
    return found


def _row(draw, properties, known):
    """The values of a row: those that are known by their property's name, drawn ones for the others."""
    row = []
    for name, kind, length in properties:
        if name in known:
            row.append(known[name])
        elif length:
            row.append(draw(st.lists(_values(kind), max_size=3)))
        else:
            row.append(draw(_values(kind)))
    return row


def _encoded(order, properties, row, blank, end):
    if not order:
        words = []
        for (_, _, length), value in zip(properties, row, strict=True):
            words += [str(len(value)), *map(_word, value)] if length else [_word(value)]
        return (blank.join(words) + end).encode()
    data = b""
    for (_, kind, length), value in zip(properties, row, strict=True):
        if length:
            data += struct.pack(order + _CODES[length], len(value))
        data += struct.pack(order + _CODES[kind] * (len(value) if length else 1), *(value if length else [value]))
    return data


@st.composite
def ply_files(draw) -> PlyFile:
    """Draws a file of vertices, polygons and strips, of which some have no corners.

    Every type of coordinates, corners, colours and lengths occurs in every byte order, beside further properties and
    elements, some of them empty. Faces may come before vertices.
    """
    kind = draw(st.sampled_from(sorted(_ORDERS)))
    order, end = _ORDERS[kind], draw(st.sampled_from(("\n", "\r\n", "\r")))
    blank = draw(st.sampled_from((" ", "\t ")))
    coordinates = [draw(st.sampled_from(sorted(_CODES))) for _ in range(3)]
    points = draw(st.lists(st.tuples(*map(_values, coordinates)), min_size=3, max_size=9))
    faces = draw(st.lists(st.lists(st.integers(0, len(points) - 1), max_size=6), min_size=1, max_size=9))
    strips = draw(st.lists(st.lists(st.integers(-1, len(points) - 1), max_size=7), max_size=4))
    vertex = draw(st.permutations([*zip("xyz", coordinates, (None,) * 3, strict=True), *draw(_others("v"))]))
    corner = draw(st.sampled_from(("vertex_indices", "vertex_index")))
    face = [(corner, draw(st.sampled_from(sorted(_INTEGERS))), draw(st.sampled_from(sorted(_CODES)))),
            *draw(_others("f"))]
    # Colours of faces are used where all triangles are faces.
    colour_kind, colours = draw(st.sampled_from((None, *sorted(_CODES)))) if not strips else None, []
    if colour_kind:
        face += [(name, colour_kind, None) for name in ("red", "green", "blue")]
        colours = [draw(st.tuples(*[_values(colour_kind)] * 3)) for _ in faces]
    face = draw(st.permutations(face))
    known = [{corner: polygon, **dict(zip(("red", "green", "blue"), colours[number] if colours else (), strict=False))}
             for number, polygon in enumerate(faces)]
    elements = [("vertex", vertex, [_row(draw, vertex, dict(zip("xyz", point, strict=True))) for point in points]),
                ("face", face, [_row(draw, face, one) for one in known])]
    if strips:
        strip = draw(st.permutations([(corner, draw(st.sampled_from(("char", "short", "int"))),
                                       draw(st.sampled_from(sorted(_INTEGERS)))), *draw(_others("s"))]))
        elements.append(("tristrips", strip, [_row(draw, strip, {corner: one}) for one in strips]))
    for number in range(draw(st.integers(0, 2))):
        more = draw(_others("e"))
        count = draw(st.integers(0, 3)) if more else 0
        elements.append((f"more{number}", more, [_row(draw, more, {}) for _ in range(count)]))
    elements = draw(st.permutations(elements))
    head, body = ["ply", f"format {kind} 1.0", "comment end_header", "obj_info Tür"], b""
    for name, properties, rows in elements:
        head.append(f"element {name} {len(rows)}")
        head += [f"property list {length} {kind} {name}" if length else f"property {kind} {name}"
                 for name, kind, length in properties]
        body += b"".join(_encoded(order, properties, row, blank, end) for row in rows)
    data = end.join([*head, "end_header", ""]).encode(draw(st.sampled_from(("utf-8", "latin-1")))) + body
    return PlyFile(data, points, faces, strips, colour_kind, colours)
