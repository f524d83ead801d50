"""Files that say the same in drawn dialects of their formats, as different programs write them.

A model is a few faces apart from one another, each with a grey. Coordinates are eighths, which every form of a number
holds exactly.
"""

import base64
import json
import struct
from dataclasses import dataclass, field
from io import BytesIO
from urllib.parse import quote

import numpy as np
from hypothesis import strategies as st
from PIL import Image

__all__ = ["DAMAGES", "DIALECTS", "DialectFile", "damaged", "encoded"]

SHAPES = (((0, 0), (1, 0), (1, 1), (0, 1)), ((0, 0), (1, 0), (0, 1)), ((0, 0), (2, 0), (1.5, 1), (0.5, 1)))
NAMES = ("Material #25", "Material #26", "Tür", "Tör", "a b", "a", "#1", "C:\\wall", "don't", "壁", "床", "K\u2028x",
         "d…", "wall\\")
FORMS = st.sampled_from(("{:g}", "{:.3f}", "{:+.4e}", "{:.5E}"))
BLANKS = st.sampled_from((" ", "  ", "\t", " \t "))


# What takes the place of bytes in a damaged file.
WORDS = (b"", b"\0", b"\xff", b"\n", b"#", b"\\", b"-1", b"nan", b"1e999", b"1_0", b"99999999", b"null", b"[]",
         b"{}", b'"')
DAMAGES = st.tuples(st.lists(st.tuples(st.integers(0, 4000), st.sampled_from(WORDS)), min_size=1, max_size=3),
                    st.sampled_from((1.0, 1.0, 0.99, 0.7)))
"""Places with words, and the share of a file that is left."""


def damaged(data: bytes, damage) -> bytes:
    """A file with one of `DAMAGES`."""
    places, end = damage
    for place, word in places:
        place %= max(1, len(data))
        data = data[:place] + word + data[place + max(1, len(word)):]
    return data[:int(end * len(data))]


@dataclass(frozen=True)
class DialectFile:
    """The files by their names, the first one the scene's, and what they say.

    That is: by a face's corners its grey and whether it is two-sided, and by corner its texture coordinates; of a light
    its kind, strength and the angles of its cone.
    """

    files: dict[str, bytes]
    faces: dict[frozenset, tuple[float, bool]]
    lights: tuple = ()
    uv: dict[tuple, tuple] = field(default_factory=dict)


@st.composite
def models(draw):
    """Draws greys by names, and faces: corners, and the name of a material."""
    chosen = draw(st.lists(st.sampled_from(NAMES), min_size=1, max_size=3, unique=True))
    greys = dict(zip(chosen, draw(st.permutations((0.0, 0.25, 0.75, 1.0))), strict=False))
    faces = []
    for number in range(draw(st.integers(1, 4))):
        shift = np.array((4 * number, *draw(st.tuples(*[st.integers(-24, 24)] * 2))), dtype=float) / (1, 8, 8)
        flat = np.array([(*corner, 0) for corner in draw(st.sampled_from(SHAPES))])
        corners = np.roll(flat, draw(st.integers(0, 2)), axis=1) + shift
        faces.append(([tuple(corner) for corner in corners.tolist()], draw(st.sampled_from(chosen))))
    return greys, faces


def said(faces, greys, *, two_sided=True):
    """What a model says."""
    return {frozenset(corners): (greys[name], two_sided) for corners, name in faces}


def encoded(draw, text: str) -> bytes:
    """A text with drawn ends of lines, in a drawn encoding, and with what DOS writes at its end or nothing."""
    text = text.replace("\n", draw(st.sampled_from(("\n", "\r\n", "\r")))) + draw(st.sampled_from(("", "", "\x1a")))
    encoding = draw(st.sampled_from(("utf-8", "utf-8-sig", "utf-16", "latin-1")))
    try:
        return text.encode(encoding)
    except UnicodeEncodeError:
        return text.encode("utf-8")


def _mtl(draw, greys, more=()):
    lines = [draw(st.sampled_from(("# made by C:\\programs\\", "", "#")))]
    for name in draw(st.permutations(list(greys))):
        members = [f"Kd {' '.join([draw(FORMS).format(greys[name])] * 3)}", "illum 1", "d 1.0", "Ka 0 0 0", *more]
        lines.append("newmtl " + draw(st.sampled_from((name, name + " ", f'"{name}"'))))
        lines += [draw(st.sampled_from(("", "\t"))) + member + draw(st.sampled_from(("", " # Kd 1 1 1")))
                  for member in draw(st.permutations(members))]
    return encoded(draw, "\n".join(lines) + draw(st.sampled_from(("\n", ""))))


@st.composite
def obj_dialects(draw):
    """OBJ: libraries before or after, quotes, comments that end in a backslash, broken lines, numbers from the end."""
    greys, faces = draw(models())
    greys = {name: grey or 0.5 for name, grey in greys.items()}
    has_uv, has_normals, uv = draw(st.booleans()), draw(st.booleans()), {}
    library = draw(st.sampled_from(("a.mtl", "my lib.mtl", "lib #1.mtl")))
    head = "mtllib " + draw(st.sampled_from((library, f'"{library}"', f'"{library}" # a #1.mtl')))
    lines, count, current = [], 0, None
    for corners, name in faces:
        words = []
        if has_uv:
            uv |= {(x, y, z): (x / 2 - y + 3, z - y / 4) for x, y, z in corners}
            lines += [f"vt {u} {v}" + draw(st.sampled_from(("", " 0", " 0.0 # vt"))) for u, v in map(uv.get, corners)]
        if has_normals:
            lines += ["vn 0 0 1"] * len(corners)
        for corner in corners:
            lines.append("v" + "".join(draw(BLANKS) + draw(FORMS).format(value) for value in corner)
                         + draw(st.sampled_from(("", " 1.0", " # v 1 2 3", " #\\", " "))))
            count += 1
        for rank in range(len(corners)):
            number = count - len(corners) + rank
            one, two, three = (str(number + 1) if draw(st.booleans()) else str(number - count) for _ in range(3))
            words.append(one + (f"/{two if has_uv else ''}" if has_uv or has_normals else "")
                         + (f"/{three}" if has_normals else ""))
        if name != current:
            lines.append("usemtl " + draw(st.sampled_from((name, f'"{name}"', f'"{name}" # it is "a" #'))))
            current = name
        lines.append("f " + draw(st.sampled_from((" ", "\t", " \\\n ", " \\ \n"))).join(words)
                     + draw(st.sampled_from(("", " ", " # f 1 2 3"))))
        lines.append(draw(st.sampled_from(("", "# from C:\\models\\", "g C:\\parts\\", "g part #1", "o Tür", "s off",
                                           "vn 0 0 1"))))
    lines.insert(draw(st.sampled_from((0, len(lines)))), head)
    text = "\n".join(lines) + draw(st.sampled_from(("", "\n", " \\")) if lines[-1] == "" else st.just("\n"))
    picture = BytesIO()
    Image.new("RGB", (2, 2), "white").save(picture, "PNG")
    files = {"a.obj": encoded(draw, text), library: _mtl(draw, greys, ["map_Kd p.png"] if has_uv else []),
             "p.png": picture.getvalue()}
    return DialectFile(files, said(faces, greys), uv=uv)


def triangles(faces):
    """The halves of the faces, one after the other."""
    return [(half, name) for corners, name in faces for half in (
        [corners] if len(corners) == 3 else [[corners[0], *corners[1:3]], [corners[0], *corners[2:]]])]


@st.composite
def stl_dialects(draw):
    """STL: binary, or text with keywords in any case, several solids, names that hold keywords, normals of any kind."""
    _, faces = draw(models())
    halves = triangles(faces)
    expected = said(faces, dict.fromkeys(NAMES, 0.5))
    if draw(st.booleans()):
        data = draw(st.sampled_from((b"solid ", b"\0", b"made"))).ljust(80, b"\0") + struct.pack("<I", len(halves))
        for half, _ in halves:
            data += struct.pack("<12fH", *draw(st.sampled_from(((0, 0, 1), (np.nan,) * 3))), *np.ravel(half), 0)
        return DialectFile({"a.stl": data}, expected)
    case, blank = draw(st.sampled_from((str, str.upper, str.title))), draw(BLANKS)
    end = draw(st.sampled_from(("end", "end ")))
    solids, lines = np.array_split(np.arange(len(halves)), draw(st.integers(1, 2))), []
    for solid in solids:
        name = draw(st.sampled_from(("", "facet vertex", "Tür", "endsolid")))
        lines.append(case("solid ") + name)
        for number in solid.tolist():
            lines += [case("facet normal ") + draw(st.sampled_from(("0 0 1", "nan nan -nan(ind)", "0 0 0"))),
                      blank + case("outer loop")]
            lines += [2 * blank + case("vertex") + "".join(blank + draw(FORMS).format(value) for value in corner)
                      for corner in halves[number][0]]
            lines += [blank + case(f"{end}loop"), case(f"{end}facet")]
        lines.append(case(f"{end}solid ") + name)
    return DialectFile({"a.stl": encoded(draw, "\n".join(lines) + "\n")}, expected)


@st.composite
def vs3_dialects(draw):
    """View3D: keywords in any case, comments, titles, names of several words; surfaces have one side."""
    greys, faces = draw(models())
    lines, count = [draw(st.sampled_from(("T a title", "! C none", "/ x"))), "F 3"], 0
    corners = [corner for face, _ in faces for corner in face]
    for number, corner in enumerate(corners, 1):
        lines.append(f"{draw(st.sampled_from('vV'))} {number}" + "".join(
            draw(BLANKS) + draw(FORMS).format(value) for value in corner) + draw(st.sampled_from(("", " ! V 9"))))
    for number, (face, name) in enumerate(faces, 1):
        words = [*range(count + 1, count + 1 + len(face)), *([0] if len(face) == 3 else [])]
        count += len(face)
        lines.append(draw(BLANKS).join(map(str, (draw(st.sampled_from("sS")), number, *words, 0, 0,
                                                 draw(FORMS).format(1 - greys[name]), name))))
    lines += draw(st.sampled_from(([], ["End of data", "S 1"], ["* end"])))
    return DialectFile({"a.vs3": encoded(draw, "\n".join(lines) + "\n")}, said(faces, greys, two_sided=False))


@st.composite
def nff_dialects(draw):
    """NFF: numbers of an entity on any lines, with comments."""
    greys, faces = draw(models())
    lines = ["# C:\\models\\"]
    for corners, name in faces:
        grey = draw(FORMS).format(greys[name])
        lines.append(f"f {grey} {grey} {grey} 1 0 0 0 0")
        words = [f"p {len(corners)}", *(draw(FORMS).format(value) for corner in corners for value in corner)]
        lines.append("".join(word + draw(st.sampled_from((" ", "\n", "\t", " # p 3\n"))) for word in words))
    return DialectFile({"a.nff": encoded(draw, "\n".join(lines) + "\n")}, said(faces, greys))


class _Gltf:
    """Buffers and accessors of a glTF file in the making."""

    def __init__(self, draw):
        self.draw, self.data, self.views, self.accessors = draw, b"", [], []

    def view(self, data, **more):
        """The number of a view of bytes."""
        self.data += b"\0" * draw_padding(self.draw, len(self.data))
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), **more})
        self.data += data
        return len(self.views) - 1

    def accessor(self, values, code, kind, width, **more):
        """The number of an accessor, which may be interleaved, at an offset, or of sparse values."""
        table = np.asarray(values).reshape(len(values), -1).astype(kind)
        names = {1: "SCALAR", 3: "VEC3", 4: "VEC4"}
        accessor = {"componentType": code, "count": len(table), "type": names[width], **more}
        form = self.draw(st.sampled_from(("plain", "offset", "stride", "sparse", "zeros")))
        if form == "stride" and width > 1:
            padded = np.zeros((len(table), table.shape[1] * table.itemsize + 4), np.uint8)
            padded[:, :-4] = np.ascontiguousarray(table).view(np.uint8).reshape(len(table), -1)
            accessor["bufferView"] = self.view(padded.tobytes(), byteStride=padded.shape[1])
        elif form in ("sparse", "zeros"):
            places = np.arange(len(table)) if form == "zeros" else np.arange(0, len(table), 2)
            if form == "sparse":
                rest = table.copy()
                rest[places] = 7
                accessor["bufferView"] = self.view(rest.tobytes())
            accessor["sparse"] = {"count": len(places), "values": {"bufferView": self.view(table[places].tobytes())},
                                  "indices": {"bufferView": self.view(places.astype("<u2").tobytes()),
                                              "componentType": 5123}}
        else:
            offset = 8 if form == "offset" else 0
            accessor |= {"bufferView": self.view(b"\0" * offset + table.tobytes()), "byteOffset": offset}
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def draw_padding(draw, length):
    """Bytes that are left out before a view, which begins at a multiple of 4."""
    return -length % 4 + draw(st.sampled_from((0, 4)))


def _lights(draw):
    """Lights of a file, and what they say: kind, position or direction, intensity, and the angles of a cone."""
    found, sources = [], []
    for _ in range(draw(st.integers(0, 2))):
        kind, strength = draw(st.sampled_from(("point", "spot", "directional"))), draw(st.sampled_from((1.0, 8.0)))
        inner, outer = draw(st.sampled_from(((0.0, np.pi / 4), (0.5, 0.5), (0.25, float(np.float32(np.pi / 2))))))
        source = {"type": kind, "intensity": strength, "color": [1, 0.5, 0]}
        if kind == "spot":
            source["spot"] = {"innerConeAngle": inner, "outerConeAngle": outer}
        cone = (round(np.degrees(inner), 4), round(np.degrees(outer), 4)) if kind == "spot" else ()
        sources.append(source)
        found.append((kind, (strength, strength / 2, 0.0), cone))
    return sources, tuple(found)


@st.composite
def gltf_dialects(draw):
    """GLTF and GLB: strips and fans; quantised, sparse and interleaved numbers; instances; encoded, embedded files."""
    greys, faces = draw(models())
    made, meshes, nodes = _Gltf(draw), [], []
    names, two_sided = list(greys), draw(st.sampled_from((None, False, True)))
    for corners, name in faces:
        mode = draw(st.sampled_from((4, 5, 6)))
        order = {4: [0, 1, 2, 0, 2, 3], 5: [0, 1, 3, 2], 6: [0, 1, 2, 3]}[mode] if len(corners) == 4 else [0, 1, 2]
        points = np.array(corners)
        scale, code, kind = draw(st.sampled_from(((1, 5126, "<f4"), (8, 5122, "<i2"))))
        primitive = {"attributes": {}, "mode": mode, "material": names.index(name)}
        if draw(st.booleans()):
            index = draw(st.sampled_from(((5121, "<u1"), (5123, "<u2"), (5125, "<u4"))))
            primitive["indices"] = made.accessor(order, *index, 1)
        else:
            points = points[order]
        shift = np.array(draw(st.sampled_from(((0, 0, 0), (1, -2, 3)))), dtype=float)
        primitive["attributes"]["POSITION"] = made.accessor((points - shift) * scale, code, kind, 3)
        meshes.append({"primitives": [primitive]})
        node = {"mesh": len(meshes) - 1, "scale": [1 / scale] * 3, "translation": shift.tolist()}
        if draw(st.booleans()):
            placed = made.accessor([shift], 5126, "<f4", 3), made.accessor([[1 / scale] * 3], 5126, "<f4", 3)
            node = {"mesh": len(meshes) - 1, "extensions": {"EXT_mesh_gpu_instancing": {
                "attributes": dict(zip(("TRANSLATION", "SCALE"), placed, strict=True))}}}
        nodes.append(node)
    sources, lights = _lights(draw)
    nodes += [{"extensions": {"KHR_lights_punctual": {"light": number}}} for number in range(len(sources))]
    materials = [{"name": name, "pbrMetallicRoughness": {"baseColorFactor": [greys[name]] * 3 + [1],
                                                         "metallicFactor": 0},
                  **({} if two_sided is None else {"doubleSided": two_sided})} for name in names]
    tree = {"asset": {"version": "2.0"}, "nodes": nodes, "meshes": meshes, "materials": materials,
            "accessors": made.accessors, "bufferViews": made.views, "buffers": [{"byteLength": len(made.data)}]}
    if draw(st.booleans()):
        tree |= {"scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}]}
    if sources:
        tree["extensions"] = {"KHR_lights_punctual": {"lights": sources}}
    expected = said(faces, greys, two_sided=bool(two_sided))
    form = draw(st.sampled_from(("glb", "plain.bin", "my mesh ü.bin", "data")))
    if form == "glb":
        text, data = json.dumps(tree).encode(), made.data + b"\0" * (-len(made.data) % 4)
        text += b" " * (-len(text) % 4)
        head = struct.pack("<4s4I", b"glTF", 2, 28 + len(text) + len(data), len(text), 0x4E4F534A)
        return DialectFile({"a.glb": head + text + struct.pack("<2I", len(data), 0x004E4942) + data}, expected, lights)
    files = {} if form == "data" else {form: made.data}
    tree["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(made.data).decode() \
        if form == "data" else draw(st.sampled_from((form, quote(form))))
    return DialectFile({"a.gltf": json.dumps(tree).encode(), **files}, expected, lights)


DIALECTS = {"obj": obj_dialects(), "stl": stl_dialects(), "vs3": vs3_dialects(), "nff": nff_dialects(),
            "gltf": gltf_dialects()}
"""Strategies of `DialectFile`s by the format."""
