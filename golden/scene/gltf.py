"""Reader of glTF 2.0 and GLB files: geometry through trimesh; materials, camera and lights from the JSON part.

trimesh rounds colours to 8 bits, drops the material extensions and makes every camera a child of the world.
"""

import json
import struct
from dataclasses import dataclass, field, replace
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import trimesh

from golden.errors import InputError
from golden.scene.appearance import UNSPECIFIED, bounded_material, colour_materials, from_srgb, to_srgb
from golden.scene.camera import Camera
from golden.scene.gltf_tree import MOST_FACES, check_tree
from golden.scene.gltf_unused import check_required, unused_of
from golden.scene.lights import Cone, DirectionalLight, PointLight
from golden.scene.material import Material
from golden.scene.mesh import Mesh
from golden.scene.parser import check_regular, load_with_trimesh, unreadable
from golden.scene.texture import MOST_PIXELS, Texture, join_halves
from golden.scene.textures import FaceTextures
from golden.scene.unused import Unused

__all__ = ["EXACT", "gltf_material", "read_gltf", "split_glb"]

MIRROR_ROUGHNESS = 0.25
"""Largest roughness of a metal that counts as a mirror; above it the reflection counts as diffuse."""

EXACT = "radiosity_engine"
"""Key in a material's extras of its exact shares, written where glTF's own model cannot express them."""

EXACT_SHARES = ("diffuse", "specular", "transparent", "refraction_index", "thin", "emission")

WRAPS = {10497: "repeat", 33071: "clamp", 33648: "mirror"}
"""Modes of samplers outside of a picture."""

COMPRESSED = {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}
JSON_CHUNK = 0x4E4F534A


@dataclass
class View:
    """Contents of the nodes besides meshes."""

    camera: Camera | None = None
    lights: list[PointLight | DirectionalLight] = field(default_factory=list)


def split_glb(data: bytes) -> tuple[dict, bytes]:
    """The JSON part of a GLB file and the chunks that follow it.

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
    return json.loads(data[20:20 + chunk].decode("utf-8")), data[20 + chunk:length]


def _join_glb(tree: dict, rest: bytes) -> bytes:
    """The GLB file of a JSON part and the chunks that follow it."""
    text = json.dumps(tree).encode("utf-8")
    text += b" " * (-len(text) % 4)
    return struct.pack("<4s4I", b"glTF", 2, 20 + len(text) + len(rest), len(text), JSON_CHUNK) + text + rest


def gltf_material(source: dict, name: str, *, colour=None, emission_colour=None) -> Material:
    """The material of a glTF material object.

    base = ``baseColorFactor`` times ``colour`` (of texture and vertex colours). Metals reflect base as mirrors
    with ``roughnessFactor`` up to 0.25, else diffusely. Dielectrics reflect base diffusely, less the share that
    ``KHR_materials_transmission`` transmits. With ``alphaMode`` BLEND the share 1 - alpha is transmitted unrefracted.
    ``KHR_materials_ior`` is the index of both; only bodies (``KHR_materials_volume`` with a thickness) refract, all
    else is a thin sheet.
    ``emissiveFactor`` times ``KHR_materials_emissive_strength`` is radiance.
    """
    exact = source.get("extras")
    exact = exact.get(EXACT) if isinstance(exact, dict) else None
    if exact:
        return bounded_material(name, **{share: exact[share] for share in EXACT_SHARES if share in exact})
    pbr, extensions = source.get("pbrMetallicRoughness", {}), source.get("extensions", {})
    *base, alpha = pbr.get("baseColorFactor", (1, 1, 1, 1))
    base = np.clip(np.array(base, dtype=np.float64) * (1 if colour is None else colour), 0, 1)
    metallic = float(np.clip(pbr.get("metallicFactor", 1.0), 0, 1))
    alpha = float(np.clip(alpha, 0, 1)) if source.get("alphaMode") == "BLEND" else 1.0
    transmitted = float(np.clip(extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0), 0, 1))
    mirror = pbr.get("roughnessFactor", 1.0) <= MIRROR_ROUGHNESS
    body = (1 - metallic) * base
    transparent = alpha * transmitted * body + (1 - alpha)
    index = extensions.get("KHR_materials_ior", {}).get("ior", UNSPECIFIED.refraction_index)
    thin = transparent.any() and not extensions.get("KHR_materials_volume", {}).get("thicknessFactor", 0.0) > 0
    if thin and not transmitted:  # a share of the face is open
        index = 1.0
    strength = extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
    emission = strength * np.array(source.get("emissiveFactor", (0, 0, 0)), dtype=np.float64)
    return bounded_material(
        name, diffuse=alpha * ((1 - transmitted) * body + (0 if mirror else metallic * base)),
        specular=alpha * metallic * base if mirror else np.zeros(3), transparent=transparent, refraction_index=index,
        thin=bool(thin), emission=emission * (1 if emission_colour is None else emission_colour))


def _local(node: dict) -> np.ndarray:
    """4 x 4 matrix of a node relative to its parent."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    matrix = np.eye(4)
    x, y, z, w = np.array(node.get("rotation", (0, 0, 0, 1)), dtype=np.float64)
    matrix[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                      [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                      [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
    matrix[:3, :3] *= np.array(node.get("scale", (1, 1, 1)), dtype=np.float64)
    matrix[:3, 3] = node.get("translation", (0, 0, 0))
    return matrix


def _walk(tree: dict):
    """Yields the nodes of the scene with their 4 x 4 world matrices, parents first."""
    nodes, scenes = tree.get("nodes", []), tree.get("scenes", [])
    roots = scenes[tree.get("scene", 0)].get("nodes", []) if scenes else []
    waiting = [(root, np.eye(4), 0) for root in reversed(roots)]
    while waiting:
        number, above, depth = waiting.pop()
        if depth > len(nodes):
            raise InputError("its nodes form a cycle")
        node = nodes[number]
        matrix = above @ _local(node)
        yield node, matrix
        waiting.extend((child, matrix, depth + 1) for child in reversed(node.get("children", [])))


def _view(tree: dict) -> View:
    """Camera and lights of the scene; removes the cameras from the nodes."""
    view = View()
    lights = tree.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
    for node, matrix in _walk(tree):
        number = node.pop("camera", None)  # with a camera, trimesh drops the node's children
        lens = None if number is None else tree["cameras"][number].get("perspective")
        if view.camera is None and lens is not None:
            eye, back = matrix[:3, 3], matrix[:3, 2]
            view.camera = Camera(eye=tuple(eye), target=tuple(eye - back / np.linalg.norm(back)),
                                 up=tuple(matrix[:3, 1]), fov=float(np.degrees(lens["yfov"])))
        number = node.get("extensions", {}).get("KHR_lights_punctual", {}).get("light")
        light = None if number is None else _light(lights[number], matrix)
        if light is not None:
            view.lights.append(light)
    return view


def _light(source: dict, matrix: np.ndarray) -> PointLight | DirectionalLight | None:
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
        cone = Cone(direction=direction, inner=float(np.degrees(spot.get("innerConeAngle", 0.0))),
                    outer=float(np.degrees(spot.get("outerConeAngle", np.pi / 4))))
    return PointLight(position=tuple(matrix[:3, 3].tolist()), intensity=intensity, cone=cone)


def _label(tree: dict) -> list[dict]:
    """Names every material by its number, by which trimesh's materials are matched; returns the original materials."""
    materials = tree.get("materials", [])
    tree["materials"] = [{**material, "name": str(number)} for number, material in enumerate(materials)]
    for material in tree["materials"]:
        for member in "extensions", "extras":
            material.pop(member, None)
    return materials


def _texture(geometry, name: str, info: dict | None, tree: dict, read: dict[int, Texture]) -> Texture | None:
    """A texture of a mesh's material; None if the material has none.

    Parameters
    ----------
    geometry
        trimesh's mesh.
    name, info
        The texture's name in trimesh's material, and the glTF object that refers to it.
    tree
        The file's JSON part, for samplers.
    read
        The textures that were decoded, by number.

    Raises
    ------
    InputError
        The texture cannot be read or decoded.
    """
    if info is None:
        return None
    picture = getattr(geometry.visual.material, name, None)
    if picture is None:
        raise InputError(f"{name} {info['index']} cannot be read as a picture of at most {MOST_PIXELS} pixels")
    if info["index"] not in read:
        texture = tree["textures"][info["index"]]
        sampler = tree["samplers"][texture["sampler"]] if "sampler" in texture else {}
        read[info["index"]] = Texture(picture, wrap=(WRAPS.get(sampler.get("wrapS"), "repeat"),
                                                     WRAPS.get(sampler.get("wrapT"), "repeat")))
    return read[info["index"]]


def _texture_colours(geometry, faces: np.ndarray, texture: Texture | None) -> np.ndarray | None:
    """F x 3 linear means of a texture over the faces of a mesh."""
    if texture is None:
        return None
    uv = geometry.visual.uv
    if uv is None:
        return np.tile(texture.mean(), (len(faces), 1))
    colours = texture.means(np.asarray(uv, dtype=np.float64)[faces])
    return join_halves(np.asarray(geometry.vertices, dtype=np.float64)[faces], colours)


def _vertex_colours(geometry, faces: np.ndarray) -> np.ndarray | None:
    """F x 3 means of the linear colours at the corners; None if vertices have no colours."""
    visual = geometry.visual
    colours = visual.vertex_attributes.get("color") if visual.kind == "texture" else None
    if visual.kind == "vertex":
        colours = visual.vertex_colors
    if colours is None or len(colours) != len(geometry.vertices):
        return None
    colours = np.asarray(colours)
    scale = np.iinfo(colours.dtype).max if colours.dtype.kind == "u" else 1
    return (colours[:, :3].astype(np.float64) / scale)[faces].mean(axis=1)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Surfaces:
    """The materials of one mesh, F indices into them, and whether it is one-sided.

    With a texture of what reflects, ``colour`` has its F x 3 linear colours in these materials.
    """

    materials: list[Material]
    index: np.ndarray
    one_sided: bool = False
    texture: Texture | None = None
    colour: np.ndarray | None = None


def _surfaces(geometry, sources: list[dict], faces: np.ndarray, tree: dict, read: dict[int, Texture]) -> _Surfaces:
    number = getattr(getattr(geometry.visual, "material", None), "name", None)
    colours = _vertex_colours(geometry, faces)
    if number is None or not number.isdigit():
        if colours is None:
            return _Surfaces(materials=[UNSPECIFIED], index=np.zeros(len(faces), dtype=np.int64))
        materials, index = colour_materials(colours)
        return _Surfaces(materials=list(materials), index=index)
    source = sources[int(number)]
    name = str(source.get("name", f"material {number}"))
    one_sided = source.get("doubleSided") is False
    textures = [_texture(geometry, name, part.get(name), tree, read) for part, name in (
        (source.get("pbrMetallicRoughness", {}), "baseColorTexture"), (source, "emissiveTexture"))]
    base, glow = (_texture_colours(geometry, faces, texture) for texture in textures)
    if colours is not None:
        base = colours if base is None else base * colours
    if base is None and glow is None:
        return _Surfaces(materials=[gltf_material(source, name)], index=np.zeros(len(faces), dtype=np.int64),
                         one_sided=one_sided)
    both = np.hstack([np.ones((len(faces), 3)) if part is None else part for part in (base, glow)])
    # As `colour_materials` does, a material for each different colour in 8 bits.
    steps, index = np.unique(np.rint(255 * to_srgb(both)).astype(np.int64), axis=0, return_inverse=True)
    index = index.reshape(-1)
    tints = [] if len(steps) == 1 else [" #{:02x}{:02x}{:02x}".format(*row) for row in steps[:, :3].tolist()]
    values = from_srgb(steps / 255)
    colour = values[index, :3] / (1 if colours is None else np.where(colours > 0, colours, 1))
    return _Surfaces(materials=[gltf_material(source, name + tint, colour=row[:3], emission_colour=row[3:])
                                for tint, row in zip(tints or [""], values, strict=True)],
                     index=index, one_sided=one_sided, texture=textures[0], colour=colour)


def _mesh(scene: trimesh.Scene, sources: list[dict], tree: dict, unused: Unused) -> Mesh:
    """All meshes of a scene in world coordinates, with the materials that ``sources`` and the file's ``tree`` state."""
    points, corners, indices, materials = [], [], [], {}
    textures, read = FaceTextures(), {}
    offset = count = 0
    total = sum(len(getattr(scene.geometry[scene.graph[node][1]], "faces", ())) for node in scene.graph.nodes_geometry)
    if total > MOST_FACES:
        raise InputError(f"its nodes instance {total} triangles, at most {MOST_FACES} are read")
    order = {node: position for position, node in enumerate(scene.graph.transforms.node_data)}
    for node in sorted(scene.graph.nodes_geometry, key=order.__getitem__):
        matrix, key = scene.graph[node]
        geometry = scene.geometry[key]
        if not isinstance(geometry, trimesh.Trimesh):
            continue
        faces = np.asarray(geometry.faces, dtype=np.int64)
        if len(faces) and faces.max() >= len(geometry.vertices):
            raise InputError(f"mesh {key!r} has a face with a corner at vertex {faces.max() + 1}, "
                             f"but {len(geometry.vertices)} vertices")
        if np.linalg.det(matrix[:3, :3]) < 0:  # glTF: a mirrored mesh keeps its front
            faces = faces[:, ::-1]
        found = _surfaces(geometry, sources, faces, tree, read)
        rows = np.array([materials.setdefault((material, found.one_sided), len(materials))
                         for material in found.materials])
        vertices = np.asarray(geometry.vertices, dtype=np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        if found.texture is not None and geometry.visual.uv is not None:
            corner = faces.reshape(-1)
            textures.add(found.texture, count + np.arange(len(faces)), points=vertices[corner],
                         uv=np.asarray(geometry.visual.uv, dtype=np.float64)[corner], counts=np.full(len(faces), 3),
                         colour=found.colour)
        elif found.texture is not None:
            unused.add("texture of a face without coordinates", len(faces))
        points.append(vertices)
        corners.append(faces + offset)
        indices.append(rows[found.index])
        offset += len(vertices)
        count += len(faces)
    textures.add_unused(unused)
    faces = np.concatenate(corners) if corners else np.empty((0, 3), dtype=np.int64)
    sides = np.array([one_sided for _, one_sided in materials], dtype=bool)
    return Mesh(points=np.concatenate(points) if points else np.empty((0, 3)), counts=np.full(len(faces), 3),
                corners=faces.reshape(-1), material=np.concatenate(indices) if indices else np.empty(0, dtype=np.int64),
                materials=tuple(material for material, _ in materials), one_sided=sides, textures=textures.build(count))


def read_gltf(path: Path) -> tuple[Mesh, View]:
    """The mesh of a .gltf or .glb file, with its first perspective camera and its lights.

    Candela of point and spot lights are taken as W/sr, lux of directional ones as W/m2.

    The nodes transform and instance the meshes. Textures reflect diffusely point by point
    (`golden.scene.textures.Textures`); in mirrors, transparent faces and emission they count with their mean over each
    face. Faces are one-sided if their material states ``"doubleSided": false``: many exporters omit it without regard
    to sides.

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
        tree, rest = split_glb(data) if is_binary else (json.loads(data.decode("utf-8")), b"")
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
    files = tuple(path.parent / unquote(part["uri"]) for part in (*tree.get("buffers", ()), *tree.get("images", ()))
                  if "uri" in part and not part["uri"].startswith("data:"))
    for file in files:
        if not file.resolve().is_relative_to(path.parent.resolve()):
            raise InputError(f"{file} is not read: it is outside of the file's folder")
        check_regular(file)
    unused = unused_of(tree)
    if "accessors" in tree:  # trimesh expects buffer views, even if all accessors are zeros
        tree.setdefault("bufferViews", [])
    view, sources = _view(tree), _label(tree)
    blob = _join_glb(tree, rest) if is_binary else json.dumps(tree).encode("utf-8")
    scene = load_with_trimesh(blob, kind, resolver=trimesh.resolvers.FilePathResolver(str(path)))
    mesh = replace(_mesh(scene, sources, tree, unused), files=files)
    unused.warn()
    return mesh, view
