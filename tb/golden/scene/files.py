"""Scenes as files of each format, for tests of readers."""

import json
import struct

import numpy as np
import trimesh

from golden.base.errors import InputError
from golden.scene.load import load_scene

__all__ = ["BOX", "BOX_QUADS", "ELL", "FORMATS", "SQUARE", "fans", "gltf", "obj", "ply", "refusal", "write"]

BOX = [(0, 0, 0), (2, 0, 0), (2, 3, 0), (0, 3, 0), (0, 0, 1), (2, 0, 1), (2, 3, 1), (0, 3, 1)]
BOX_QUADS = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
ELL = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)]


def write(folder, name, content):
    """Write bytes or text, and give the path."""
    path = folder / name
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        path.write_text(content, encoding="utf-8")
    return path


def obj(points, faces, *, head=""):
    """The text of an OBJ file; faces are rows of places of points, from 0."""
    return (head + "".join(f"v {x} {y} {z}\n" for x, y, z in points)
            + "".join("f " + " ".join(str(corner + 1) for corner in face) + "\n" for face in faces))


def ply(points, faces, *, kind="ascii", vertex_colours=None, face_colours=None):
    """The bytes of a PLY file."""
    colour = "".join(f"property uchar {channel}\n" for channel in ("red", "green", "blue"))
    head = (f"ply\nformat {kind} 1.0\ncomment made for a test\nelement vertex {len(points)}\n"
            "property float x\nproperty float y\nproperty float z\n" + (colour if vertex_colours else "")
            + f"element face {len(faces)}\nproperty list uchar int vertex_indices\n" + (colour if face_colours else "")
            + "end_header\n")
    rows = [(tuple(point), vertex_colours[k] if vertex_colours else ()) for k, point in enumerate(points)]
    cells = [((len(face), *face), face_colours[k] if face_colours else ()) for k, face in enumerate(faces)]
    if kind == "ascii":
        return (head + "".join(" ".join(map(str, a + tuple(b))) + "\n" for a, b in rows + cells)).encode()
    order = "<" if "little" in kind else ">"
    body = b"".join(struct.pack(f"{order}3f{len(b)}B", *a, *b) for a, b in rows)
    body += b"".join(struct.pack(f"{order}B{len(a) - 1}i{len(b)}B", *a, *b) for a, b in cells)
    return head.encode() + body


def fans(quads):
    """Two triangles for each quadrilateral."""
    return [half for a, b, c, d in quads for half in ((a, b, c), (a, c, d))]
FORMATS = {
    "quads.obj": lambda points, quads: obj(points, quads),
    "triangles.obj": lambda points, quads: obj(points, fans(quads)),
    "text.ply": lambda points, quads: ply(points, quads),
    "little.ply": lambda points, quads: ply(points, quads, kind="binary_little_endian"),
    "big.ply": lambda points, quads: ply(points, quads, kind="binary_big_endian"),
    "triangles.ply": lambda points, quads: ply(points, fans(quads), kind="binary_little_endian"),
    "binary.stl": lambda points, quads: trimesh.Trimesh(points, fans(quads), process=False).export(file_type="stl"),
    "text.stl": lambda points, quads: trimesh.Trimesh(points, fans(quads), process=False).export(file_type="stl_ascii"),
    "mesh.glb": lambda points, quads: trimesh.Trimesh(points, fans(quads), process=False).export(file_type="glb"),
}


def refusal(path):
    """The text of the error that a file is refused with."""
    try:
        load_scene(path)
    except InputError as error:
        return str(error)
    return None


def gltf(folder, *, materials=(), nodes=None, meshes=None, name="a.glb", **more):
    """One square, whose nodes and materials are given, as a file."""
    points = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype="<f4").tobytes()
    corners = np.array([0, 1, 2, 0, 2, 3], dtype="<u2").tobytes()
    tree = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": nodes or [{"mesh": 0}],
            "meshes": meshes or [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1,
                                                  **({"material": 0} if materials else {})}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                          {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
            "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48},
                            {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
            "buffers": [{"byteLength": 60}], "materials": list(materials), **more}
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    binary = points + corners
    return write(folder, name, struct.pack("<4s4I", b"glTF", 2, 28 + len(text) + len(binary), len(text), 0x4E4F534A)
                 + text + struct.pack("<2I", len(binary), 0x004E4942) + binary)
SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
