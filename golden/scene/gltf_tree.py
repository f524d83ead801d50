"""Checks of the JSON part of a glTF file: every member that the reader uses has the type that glTF 2.0 demands.

A small file may claim more than any memory holds: what it claims is bounded here, before anything is allocated.
"""

from collections.abc import Callable
from numbers import Real

from golden.base.errors import InputError
from golden.scene.gltf_buffers import COMPONENTS, WIDTHS

__all__ = ["MOST_FACES", "check_tree"]

Check = Callable[[object, str], None]

LARGEST = 1e30

MOST_FACES = 1 << 24
"""Most triangles of all meshes, and of all their instances."""

MOST_PRIMITIVES = 1 << 14
"""Most primitives of all meshes: each takes a part of a millisecond."""

MOST_ZEROS = 1 << 22
"""Most entries of accessors without a buffer view, which are zeros."""


def check_tree(tree: dict) -> None:
    """The members that `golden.scene.gltf` reads are of their types, and indices lie within their lists.

    Raises
    ------
    InputError
        Names the first member that is not, for example ``nodes[2].children``. Also if a node has two parents, or the
        file claims more than `MOST_FACES`, `MOST_PRIMITIVES` or `MOST_ZEROS`.
    """
    _TREE(tree, "")
    nodes, cameras, meshes = (len(tree.get(name, ())) for name in ("nodes", "cameras", "meshes"))
    lights = len(tree.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", ()))
    scenes = tree.get("scenes", [])
    if scenes:
        _check_index(tree.get("scene", 0), "scene", len(scenes))
    for number, scene in enumerate(scenes):
        _check_indices(scene.get("nodes", ()), f"scenes[{number}].nodes", nodes)
    for number, node in enumerate(tree.get("nodes", ())):
        path = f"nodes[{number}]"
        _check_indices(node.get("children", ()), f"{path}.children", nodes)
        if "camera" in node:
            _check_index(node["camera"], f"{path}.camera", cameras)
        if "mesh" in node:
            _check_index(node["mesh"], f"{path}.mesh", meshes)
        if "matrix" in node and node["matrix"][3::4] != [0, 0, 0, 1]:
            _refuse(f"{path}.matrix", "a matrix with the last row 0, 0, 0, 1", node["matrix"][3::4])
        light = node.get("extensions", {}).get("KHR_lights_punctual", {})
        if "light" in light:
            _check_index(light["light"], f"{path}.extensions.KHR_lights_punctual.light", lights)
        instances = node.get("extensions", {}).get("EXT_mesh_gpu_instancing", {}).get("attributes", {})
        for name, index in instances.items():
            _check_index(index, f"{path}.extensions.EXT_mesh_gpu_instancing.attributes.{name}",
                         len(tree.get("accessors", ())))
    _check_textures(tree)
    _check_buffers(tree)
    _check_parents(tree.get("nodes", ()), scenes)
    _check_sizes(tree.get("accessors", ()), tree.get("meshes", ()), len(tree.get("materials", ())))


def _check_buffers(tree):
    views, buffers = (tree.get(name, ()) for name in ("bufferViews", "buffers"))
    for number, view in enumerate(views):
        _check_index(view["buffer"], f"bufferViews[{number}].buffer", len(buffers))
    for kind in "accessors", "images":
        for number, entry in enumerate(tree.get(kind, ())):
            sparse = entry.get("sparse", {})
            for name, part in (("", entry), (".sparse.indices", sparse.get("indices", {})),
                               (".sparse.values", sparse.get("values", {}))):
                if "bufferView" in part:
                    _check_index(part["bufferView"], f"{kind}[{number}]{name}.bufferView", len(views))
            if kind == "images" and not entry.keys() & {"uri", "bufferView"}:
                raise InputError(f"images[{number}] has neither uri nor bufferView")


def _check_textures(tree):
    textures, samplers, images = (tree.get(name, ()) for name in ("textures", "samplers", "images"))
    for number, texture in enumerate(textures):
        webp = texture.get("extensions", {}).get("EXT_texture_webp", {})
        for name, part, known in (("sampler", texture, samplers), ("source", texture, images),
                                  ("source", webp, images)):
            if name in part:
                _check_index(part[name], f"textures[{number}].{name}", len(known))
    for number, material in enumerate(tree.get("materials", ())):
        for part, name in ((material.get("pbrMetallicRoughness", {}), "baseColorTexture"),
                           (material, "emissiveTexture")):
            if name in part:
                _check_index(part[name]["index"], f"materials[{number}].{name}.index", len(textures))


def _check_parents(nodes, scenes):
    """Nodes with two parents each would be as many as two to the power of their depth."""
    for number, scene in enumerate(scenes):
        if len(set(scene.get("nodes", ()))) < len(scene.get("nodes", ())):
            raise InputError(f"scenes[{number}].nodes names a node twice")
    parents: dict[int, int] = {}
    for number, node in enumerate(nodes):
        for child in node.get("children", ()):
            if parents.setdefault(child, number) != number:
                raise InputError(f"nodes[{child}] is a child of both nodes[{parents[child]}] and nodes[{number}]")
        if len(set(node.get("children", ()))) < len(node.get("children", ())):
            raise InputError(f"nodes[{number}].children names a node twice")


def _check_sizes(accessors, meshes, materials):
    counts = [accessor["count"] for accessor in accessors]
    zeros = sum(accessor["count"] for accessor in accessors if "bufferView" not in accessor)
    if zeros > MOST_ZEROS:
        raise InputError(f"its accessors claim {zeros} entries without a buffer, at most {MOST_ZEROS} are read")
    primitives = sum(len(mesh["primitives"]) for mesh in meshes)
    if primitives > MOST_PRIMITIVES:
        raise InputError(f"its meshes have {primitives} primitives, at most {MOST_PRIMITIVES} are read")
    corners = 0
    for number, mesh in enumerate(meshes):
        for rank, primitive in enumerate(mesh["primitives"]):
            path = f"meshes[{number}].primitives[{rank}]"
            attributes = primitive.get("attributes", {})
            if "material" in primitive:
                _check_index(primitive["material"], f"{path}.material", materials)
            named = {name: primitive[name] for name in ("indices",) if name in primitive}
            for name, index in (named | attributes).items():
                _check_index(index, f"{path}.{name}", len(counts))
            source = primitive.get("indices", attributes.get("POSITION"))
            corners += 0 if source is None else counts[source]
    if corners > 3 * MOST_FACES:
        raise InputError(f"its meshes have {corners} corners, at most {3 * MOST_FACES} are read")


def _refuse(path, requirement, value):
    raise InputError(f"{path or 'the file'} must be {requirement}, not {value!r:.60}")


def _check_index(value, path, length):
    if not 0 <= value < length:
        _refuse(path, f"the index of one of {length} entries", value)


def _check_indices(values, path, length):
    for value in values:
        _check_index(value, path, length)


def _number(value, path):
    if isinstance(value, bool) or not isinstance(value, Real) or not -LARGEST <= value <= LARGEST:
        _refuse(path, "a finite number", value)


def _whole(value, path):
    if isinstance(value, bool) or not isinstance(value, int):
        _refuse(path, "a whole number", value)


def _count(value, path):
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        _refuse(path, "a whole number of at least 0", value)


def _flag(value, path):
    if not isinstance(value, bool):
        _refuse(path, "true or false", value)


def _text(value, path):
    if not isinstance(value, str):
        _refuse(path, "a string", value)


def _list(element: Check, length: int | None = None) -> Check:
    def check(value, path):
        if not isinstance(value, list) or length not in (None, len(value)):
            _refuse(path, "a list" if length is None else f"a list of {length} numbers", value)
        for number, one in enumerate(value):
            element(one, f"{path}[{number}]")
    return check


def _object(required: tuple[str, ...] = (), **members: Check) -> Check:
    def check(value, path):
        if not isinstance(value, dict):
            _refuse(path, "an object", value)
        for name in required:
            if name not in value:
                raise InputError(f"{path}.{name} is missing")
        for name, member in members.items():
            if name in value:
                member(value[name], f"{path}.{name}" if path else name)
    return check


def _indices(value, path):
    """Attributes have names that the file chooses."""
    if not isinstance(value, dict):
        _refuse(path, "an object", value)
    for name, index in value.items():
        _whole(index, f"{path}.{name}")


def _extras(value, path):
    """Extras may hold anything; only our own member is read."""
    if isinstance(value, dict):
        _EXTRAS(value, path)


def _one_of(*values) -> Check:
    def check(value, path):
        if value not in values:
            _refuse(path, f"one of {', '.join(map(str, values))}", value)
    return check


_RGB = _list(_number, 3)
_EXTRAS = _object(radiosity_engine=_object(diffuse=_RGB, specular=_RGB, transparent=_RGB, refraction_index=_number,
                                           thin=_flag,
                                           emission=_RGB))
_TEXTURE = _object(("index",), index=_count, texCoord=_count, extensions=_object(KHR_texture_transform=_object(
    offset=_list(_number, 2), scale=_list(_number, 2), rotation=_number, texCoord=_count)))
_MATERIAL = _object(
    pbrMetallicRoughness=_object(baseColorFactor=_list(_number, 4), metallicFactor=_number, roughnessFactor=_number,
                                 baseColorTexture=_TEXTURE),
    emissiveTexture=_TEXTURE,
    extensions=_object(
        KHR_materials_transmission=_object(transmissionFactor=_number), KHR_materials_ior=_object(ior=_number),
        KHR_materials_volume=_object(thicknessFactor=_number),
        KHR_materials_emissive_strength=_object(emissiveStrength=_number)),
    emissiveFactor=_RGB, name=_text, extras=_extras)
_LIGHTS = _object(lights=_list(_object(type=_text, color=_RGB, intensity=_number, spot=_object(
    innerConeAngle=_number, outerConeAngle=_number))))
_NODE = _object(matrix=_list(_number, 16), rotation=_list(_number, 4), scale=_list(_number, 3),
                translation=_list(_number, 3), children=_list(_whole), camera=_whole, mesh=_whole,
                extensions=_object(KHR_lights_punctual=_object(light=_whole),
                                   EXT_mesh_gpu_instancing=_object(("attributes",), attributes=_indices)))
_MESH = _object(("primitives",), primitives=_list(_object(
    attributes=_indices, indices=_whole, material=_whole, mode=_one_of(*range(7)), extensions=_object())))
_COMPONENT = _one_of(*COMPONENTS)
_SPARSE = _object(("count", "indices", "values"), count=_count, values=_object(
    ("bufferView",), bufferView=_count, byteOffset=_count), indices=_object(
    ("bufferView", "componentType"), bufferView=_count, byteOffset=_count, componentType=_one_of(5121, 5123, 5125)))
_ACCESSOR = _object(("count", "componentType", "type"), count=_count, componentType=_COMPONENT, type=_one_of(*WIDTHS),
                    bufferView=_count, byteOffset=_count, normalized=_flag, sparse=_SPARSE)
_TREE = _object(
    accessors=_list(_ACCESSOR), bufferViews=_list(_object(
        ("buffer", "byteLength"), buffer=_count, byteOffset=_count, byteLength=_count, byteStride=_count)),
    meshes=_list(_MESH), scene=_whole, scenes=_list(_object(nodes=_list(_whole))), nodes=_list(_NODE),
    cameras=_list(_object(perspective=_object(("yfov",), yfov=_number))), materials=_list(_MATERIAL),
    extensions=_object(KHR_lights_punctual=_LIGHTS), extensionsUsed=_list(_text), extensionsRequired=_list(_text),
    animations=_list(_object()), skins=_list(_object()),
    textures=_list(_object(sampler=_count, source=_count, extensions=_object(
        EXT_texture_webp=_object(("source",), source=_count)))), samplers=_list(_object(wrapS=_count, wrapT=_count)),
    buffers=_list(_object(("byteLength",), uri=_text, byteLength=_count)), images=_list(_object(
        uri=_text, bufferView=_count)))
