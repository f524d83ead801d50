"""Reader of glTF 2.0 and GLB files."""

import json
import struct
from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.scene.camera import Camera
from golden.scene.gltf_buffers import GltfBuffers
from golden.scene.gltf_faces import TRIANGLES, GltfFaces, gltf_faces
from golden.scene.gltf_tree import MOST_FACES, check_tree
from golden.scene.gltf_unused import check_required, unused_of
from golden.scene.lights import Cone, DirectionalLight, PointLight
from golden.scene.mesh import Mesh
from golden.scene.parser import unreadable
from golden.scene.textures import FaceTextures
from golden.scene.unused import Unused

__all__ = ["read_gltf", "split_glb"]

INSTANCES = "EXT_mesh_gpu_instancing"
PLACES = {"translation": "TRANSLATION", "rotation": "ROTATION", "scale": "SCALE"}
MOST_INSTANCES = 1 << 16
"""Most instances of nodes by an extension, each of which takes a part of a millisecond."""

UNIT = 0.01
"""Largest error of a rotation's length, which those in normalised bytes have."""

STRAIGHT = 90 * (1 + 1e-6)
"""Largest angle of a cone in degrees, which rounds to 90 in float32."""

COMPRESSED = {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942


def split_glb(data: bytes) -> tuple[dict, bytes]:
    """The JSON part of a GLB file and its binary part.

    Raises
    ------
    ValueError
        The data is not GLB version 2, is incomplete, or its JSON part is malformed.
    RecursionError
        The JSON part nests too deeply.
    """
    if len(data) < 20 or data[:4] != b"glTF":
        raise ValueError("it does not start like one")
    _, version, length, chunk, kind = struct.unpack("<5I", data[:20])
    if version != 2:
        raise ValueError(f"it is version {version}, only version 2 is supported")
    if kind != JSON_CHUNK:
        raise ValueError("it does not begin with JSON")
    if length > len(data) or 20 + chunk > length:
        raise ValueError(f"it is {len(data)} bytes long and should be {max(length, 20 + chunk)}")
    tree, rest = json.loads(data[20:20 + chunk].decode("utf-8-sig")), data[20 + chunk:length]
    if len(rest) < 8 or struct.unpack("<I", rest[4:8])[0] != BINARY_CHUNK:
        return tree, b""
    size = struct.unpack("<I", rest[:4])[0]
    if 8 + size > len(rest):
        raise ValueError(f"its binary part has {len(rest) - 8} bytes and should have {size}")
    return tree, rest[8:8 + size]


def _local(node: dict) -> np.ndarray:
    """4 x 4 matrix of a node relative to its parent."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    matrix = np.eye(4)
    rotation = np.array(node.get("rotation", (0, 0, 0, 1)), dtype=np.float64)
    if not rotation.any():
        raise InputError("a rotation is 0, which is no quaternion of length 1")
    x, y, z, w = rotation / np.linalg.norm(rotation)
    matrix[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                      [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                      [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    matrix[:3, :3] *= np.array(node.get("scale", (1, 1, 1)), dtype=np.float64)
    matrix[:3, 3] = node.get("translation", (0, 0, 0))
    return matrix


def _walk(tree: dict):
    """Yields the nodes of the scene with their 4 x 4 world matrices, parents first."""
    nodes, scenes = tree.get("nodes", []), tree.get("scenes", [])
    children = {child for node in nodes for child in node.get("children", ())}
    roots = scenes[tree.get("scene", 0)].get("nodes", []) if scenes \
        else [number for number in range(len(nodes)) if number not in children]
    waiting = [(root, np.eye(4), 0) for root in reversed(roots)]
    while waiting:
        number, above, depth = waiting.pop()
        if depth > len(nodes):
            raise InputError("its nodes form a cycle")
        node = nodes[number]
        matrix = above @ _local(node)
        yield node, matrix
        waiting.extend((child, matrix, depth + 1) for child in reversed(node.get("children", [])))


def _add_lengths(rotations, unused: Unused) -> None:
    """Counts rotations that are not of length 1, as K x 4 quaternions: programs take them differently."""
    lengths = np.linalg.norm(np.array(rotations, dtype=np.float64).reshape(-1, 4), axis=1)
    unused.add("length of a rotation", int((np.abs(lengths - 1) > UNIT).sum()))


def _view(tree: dict, unused: Unused) -> dict:
    """Camera and lights of the scene, as `Scene` takes them."""
    _add_lengths([node["rotation"] for node in tree.get("nodes", ()) if "rotation" in node], unused)
    camera, found, placed = None, [], []
    lights = tree.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
    for node, matrix in _walk(tree):
        number = node.get("camera")
        lens = None if number is None else tree["cameras"][number].get("perspective")
        if lens is not None:
            placed.append(number)
        if camera is None and lens is not None:
            eye, back = matrix[:3, 3], matrix[:3, 2]
            camera = Camera(eye=tuple(eye), target=tuple(eye - back / np.linalg.norm(back)), up=tuple(matrix[:3, 1]),
                            fov=float(np.degrees(lens["yfov"])))
        number = node.get("extensions", {}).get("KHR_lights_punctual", {}).get("light")
        light = None if number is None else _light(lights[number], matrix, unused)
        if light is not None:
            found.append(light)
    unused.add("further places of a camera", len(placed) - len(set(placed)))
    return {"camera": camera, "lights": tuple(found)}


def _light(source: dict, matrix: np.ndarray, unused: Unused) -> PointLight | DirectionalLight | None:
    """The light of a node with a 4 x 4 world matrix; None if its type is unknown."""
    colour = np.array(source.get("color", (1, 1, 1)), dtype=np.float64)
    intensity = tuple((colour * source.get("intensity", 1.0)).tolist())
    direction, kind = tuple((-matrix[:3, 2]).tolist()), source.get("type")
    if kind == "directional":
        return DirectionalLight(direction=direction, irradiance=intensity)
    if kind not in ("point", "spot"):
        return None
    cone = None
    if kind == "spot":
        spot = source.get("spot", {})
        inner, outer = (float(np.degrees(spot.get(name, default))) for name, default in (
            ("innerConeAngle", 0.0), ("outerConeAngle", np.pi / 4)))
        outer = min(outer, 90.0) if outer <= STRAIGHT else outer
        unused.add("innerConeAngle beyond outerConeAngle", inner > outer * (1 + 1e-6))
        cone = Cone(direction=direction, inner=min(inner, outer), outer=outer)
    return PointLight(position=tuple(matrix[:3, 3].tolist()), intensity=intensity, cone=cone)


def _placed(node: dict) -> dict[str, int]:
    """The accessors of a node's instances by what they state; empty without any."""
    attributes = node.get("extensions", {}).get(INSTANCES, {}).get("attributes", {})
    return {name: attributes[key] for name, key in PLACES.items() if key in attributes}


def _count(node: dict, tree: dict) -> int:
    """How often a node's mesh is placed."""
    counts = {tree["accessors"][number]["count"] for number in _placed(node).values()}
    if len(counts) > 1:
        raise InputError(f"attributes of {INSTANCES} must have one count, not {sorted(counts)}")
    return counts.pop() if counts else 1


def _instances(node: dict, matrix: np.ndarray, buffers: GltfBuffers, unused: Unused) -> list[np.ndarray]:
    """The 4 x 4 world matrices of a node's mesh."""
    columns = {name: buffers.values(number, "VEC4" if name == "rotation" else "VEC3").astype(np.float64).tolist()
               for name, number in _placed(node).items()}
    if not columns:
        return [matrix]
    _add_lengths(columns.get("rotation", ()), unused)
    return [matrix @ _local(dict(zip(columns, row, strict=True))) for row in zip(*columns.values(), strict=True)]


def _corners(tree: dict, mesh: dict) -> int:
    """An upper bound of a mesh's triangles."""
    total = 0
    for primitive in mesh["primitives"]:
        source = primitive.get("indices", primitive.get("attributes", {}).get("POSITION"))
        mode = primitive.get("mode", 4)
        if source is not None and mode in TRIANGLES:
            total += tree["accessors"][source]["count"] // (3 if mode == 4 else 1)
    return total


def _mesh(tree: dict, buffers: GltfBuffers, unused: Unused) -> Mesh:
    """All meshes of the scene in world coordinates."""
    nodes = [(node, matrix) for node, matrix in _walk(tree) if "mesh" in node]
    instances = sum(_count(node, tree) for node, _ in nodes)
    if instances > MOST_INSTANCES + len(nodes):
        raise InputError(f"its nodes have {instances} instances, at most {MOST_INSTANCES} are read")
    total = sum(_count(node, tree) * _corners(tree, tree["meshes"][node["mesh"]]) for node, _ in nodes)
    if total > MOST_FACES:
        raise InputError(f"its nodes instance {total} triangles, at most {MOST_FACES} are read")
    places = [(node["mesh"], placed) for node, matrix in nodes for placed in _instances(node, matrix, buffers, unused)]
    read: dict[int, list[GltfFaces]] = {}
    points, corners, indices, materials = [np.empty((0, 3))], [np.empty((0, 3), np.int64)], [np.empty(0, np.int64)], {}
    textures, offset, count = FaceTextures(), 0, 0
    for number, matrix in places:
        if number not in read:
            parts = (gltf_faces(primitive, f"meshes[{number}].primitives[{rank}]", tree, buffers, unused)
                     for rank, primitive in enumerate(tree["meshes"][number]["primitives"]))
            read[number] = [part for part in parts if part is not None]
        turn = slice(None, None, -1 if np.linalg.det(matrix[:3, :3]) < 0 else 1)  # a mirrored mesh keeps its front
        for part in read[number]:
            vertices, faces = part.points @ matrix[:3, :3].T + matrix[:3, 3], part.faces[:, turn]
            rows = np.array([materials.setdefault((material, part.one_sided), len(materials))
                             for material in part.materials])
            if part.uv is not None:
                textures.add(part.texture, count + np.arange(len(faces)), points=vertices[faces.reshape(-1)],
                             uv=part.uv[:, turn].reshape(-1, 2), counts=np.full(len(faces), 3), colour=part.colour)
            points.append(vertices)
            corners.append(faces + offset)
            indices.append(rows[part.index])
            offset += len(vertices)
            count += len(faces)
    textures.add_unused(unused)
    return Mesh(points=np.concatenate(points), counts=np.full(count, 3), corners=np.concatenate(corners).reshape(-1),
                material=np.concatenate(indices), materials=tuple(material for material, _ in materials),
                one_sided=np.array([one_sided for _, one_sided in materials], dtype=bool),
                textures=textures.build(count), files=buffers.files)


def read_gltf(path: Path) -> tuple[Mesh, dict]:
    """The mesh of a .gltf or .glb file, and its first perspective camera and its lights, as `Scene` takes them.

    Candela of point and spot lights are taken as W/sr, lux of directional ones as W/m2.

    The nodes transform and instance the meshes. Textures reflect diffusely point by point
    (`golden.scene.textures.Textures`); in mirrors, transparent faces and emission they count with their mean over each
    face. Faces are one-sided unless their material states ``"doubleSided": true``.

    Raises
    ------
    InputError
        The file is malformed, of another version, or compressed; the message lacks the path.
    OSError
        The file, or a buffer or texture that it names, cannot be read.

    Warns
    -----
    InputWarning
        Names what is not used.
    """
    data = path.read_bytes()
    is_binary = path.suffix.lower() == ".glb"
    kind = "glb" if is_binary else "gltf"
    try:
        tree, rest = split_glb(data) if is_binary else (json.loads(data.decode("utf-8-sig")), b"")
    except InputError:
        raise
    except (ValueError, RecursionError) as error:
        raise unreadable(kind.upper(), error) from error
    asset = tree.get("asset") if isinstance(tree, dict) else None
    if not isinstance(asset, dict) or not str(asset.get("version", "")).startswith("2"):
        raise unreadable(kind.upper(), "it is not of version 2")
    check_tree(tree)
    compressed = COMPRESSED.intersection(tree.get("extensionsUsed", ()))
    if compressed:
        raise InputError(f"its geometry is compressed with {compressed.pop()}, which cannot be read")
    check_required(tree)
    buffers = GltfBuffers(tree, path, rest)
    unused = unused_of(tree)
    view = _view(tree, unused)
    mesh = _mesh(tree, buffers, unused)
    unused.warn()
    return mesh, view
