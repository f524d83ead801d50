"""OBJ files in drawn dialects: numbers from the start or from the end, further coordinates, broken and empty lines."""

from dataclasses import dataclass, field

from hypothesis import strategies as st

__all__ = ["ObjFile", "obj_files"]

_NUMBERS = st.integers(-64, 64).map(lambda value: value / 8)
_FORMS = st.sampled_from(("{:g}", "{:.3f}", "{:+.4e}"))
_BLANKS = st.sampled_from((" ", "  ", "\t", " \\\n "))


@dataclass
class ObjFile:
    """The text of a file; its vertices, texture coordinates and faces, of which each has the corners' numbers in both.

    A corner without texture coordinates has -1 there.
    """

    text: str = ""
    points: list[tuple[float, ...]] = field(default_factory=list)
    uv: list[tuple[float, ...]] = field(default_factory=list)
    faces: list[list[tuple[int, int]]] = field(default_factory=list)


def _number(draw, index, count):
    """The name of the entry at an index, from the start or from the end of those so far."""
    return str(index - count) if draw(st.booleans()) else str(index + 1)


def _face(draw, file, normals):
    """The words of a face whose corners may all have texture coordinates and normals."""
    has_uv, has_normal = (draw(st.booleans()) and count > 0 for count in (len(file.uv), normals))
    corners, words = [], ["f"]
    for _ in range(draw(st.integers(3, 5))):
        point = draw(st.integers(0, len(file.points) - 1))
        uv = draw(st.integers(0, len(file.uv) - 1)) if has_uv else -1
        word = _number(draw, point, len(file.points))
        if has_uv or has_normal:
            word += "/" + (_number(draw, uv, len(file.uv)) if has_uv else "")
        if has_normal:
            word += "/" + _number(draw, draw(st.integers(0, normals - 1)), normals)
        corners.append((point, uv))
        words.append(word)
    file.faces.append(corners)
    return words


@st.composite
def obj_files(draw) -> ObjFile:
    """Draws a file in which vertices, texture coordinates, normals and faces follow one another in any order."""
    file, normals, lines = ObjFile(), 0, []
    more = st.sampled_from(("v", "vt", "vn", "f", "f", "s", "o", "g", "", "#"))
    kinds = ["v", "v", "v", *draw(st.lists(more, max_size=20)), "f"]
    for kind in kinds:
        form = draw(_FORMS)
        if kind == "v":
            file.points.append(draw(st.tuples(*[_NUMBERS] * 3)))
            words = ["v", *map(form.format, file.points[-1]), *draw(st.sampled_from(((), ("1.0",))))]
        elif kind == "vt":
            file.uv.append(draw(st.tuples(*[_NUMBERS] * 2)))
            words = ["vt", *map(form.format, file.uv[-1]), *draw(st.sampled_from(((), ("0",))))]
        elif kind == "vn":
            normals += 1
            words = ["vn", "0", "0", "1"]
        elif kind == "f":
            words = _face(draw, file, normals)
        else:
            words = {"s": ["s", "1"], "o": ["o", "f"], "g": ["g", "part", "v"], "": [], "#": ["# f 9 9 9"]}[kind]
        end = draw(st.sampled_from(("", " ", " # f 1 2 3"))) if words and kind != "#" else ""
        lines.append(draw(_BLANKS).join(words) + end)
    file.text = draw(st.sampled_from(("\n", "\r\n"))).join("\n".join(lines).split("\n")) + "\n"
    return file
