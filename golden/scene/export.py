"""Scenes written to files."""

import re
from pathlib import Path

import numpy as np
import trimesh

from golden.base.errors import InputError
from golden.base.output import check_inputs_stay, check_text_name, whole_file
from golden.scene.adjacency import corner_numbers
from golden.scene.appearance import to_srgb
from golden.scene.gltf_material import EXACT, EXACT_SHARES, gltf_material
from golden.scene.lights import DirectionalLight, PointLight
from golden.scene.material import Material
from golden.scene.scene import Scene

__all__ = ["FORMATS", "Y_UP", "export_scene", "rotation_between"]

FORMATS = (".glb", ".obj", ".ply", ".stl")

Y_UP, Z_UP = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def rotation_between(up, toward) -> np.ndarray:
    """The shortest rotation from the direction ``up`` to ``toward``; exact between axes."""
    up, toward = np.array(up) / np.linalg.norm(up), np.array(toward)
    cosine = up @ toward
    if cosine < -1 + 1e-12:
        side = np.eye(3)[np.abs(toward).argmin()]
        return 2 * np.outer(side, side) - np.eye(3)
    x, y, z = np.cross(up, toward)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + cross + cross @ cross / (1 + cosine)


def _indexed(scene: Scene, rotation: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distinct vertices, rotated, and N x 4 numbers of each patch's corners."""
    corners = corner_numbers(scene.vertices)
    _, first = np.unique(corners, return_index=True)
    return scene.vertices.reshape(-1, 3)[first] @ rotation.T + 0.0, corners


def _triangles(corners: np.ndarray, is_triangle: np.ndarray) -> np.ndarray:
    """Triangles of patches, the halves of a quad one after the other."""
    halves = corners[:, [[0, 1, 2], [0, 2, 3]]]
    kept = np.stack((np.ones_like(is_triangle), ~is_triangle), axis=1)
    return halves[kept]


def _numbers(values) -> str:
    return " ".join(repr(float(value)) for value in values)


def _is_same(one: Material, other: Material) -> bool:
    names = ("diffuse", "specular", "transparent", "emission", "refraction_index")
    return one.thin == other.thin and all(
        np.allclose(getattr(one, name), getattr(other, name), rtol=1e-12, atol=1e-15) for name in names)


def _to_gltf(material: Material, *, two_sided: bool) -> dict:
    """The glTF material that `gltf_material` reads as ``material``; if there is none, the nearest with exact extras."""
    diffuse, specular, transparent = (np.array(getattr(material, name)) for name in
                                      ("diffuse", "specular", "transparent"))
    base = np.minimum(diffuse + specular + transparent, 1)
    total = max(base.sum(), 1e-300)
    metallic = float(specular.sum() / total)
    transmitted = float(transparent.sum() / max((diffuse + transparent).sum(), 1e-300))
    strongest = max(1.0, *material.emission)
    source = {"name": material.name, "doubleSided": two_sided,
            "pbrMetallicRoughness": {"baseColorFactor": [*base.tolist(), 1.0], "metallicFactor": metallic,
                                     "roughnessFactor": 0.0 if metallic or transmitted else 1.0}}
    extensions = {"KHR_materials_ior": {"ior": material.refraction_index}}
    if material.emits:
        source["emissiveFactor"] = [channel / strongest for channel in material.emission]
        if strongest > 1:
            extensions["KHR_materials_emissive_strength"] = {"emissiveStrength": strongest}
    if transmitted:
        extensions["KHR_materials_transmission"] = {"transmissionFactor": transmitted}
        if material.refraction_index > 1 and not material.thin:
            extensions["KHR_materials_volume"] = {"thicknessFactor": 1.0}
    source["extensions"] = extensions
    if not _is_same(gltf_material(source, material.name), material):
        source["extras"] = {EXACT: {name: getattr(material, name) for name in EXACT_SHARES
                                    if name != "thin" or material.thin}}
    return source


def _light(light: PointLight | DirectionalLight) -> dict:
    """The glTF object of a light, without its place."""
    is_point = isinstance(light, PointLight)
    intensity = np.array(light.intensity if is_point else light.irradiance)
    strength = max(1e-300, *intensity)
    source = {"type": "point" if is_point else "directional", "intensity": float(strength),
              "color": (intensity / strength).tolist()}
    if is_point and light.cone is not None:
        source |= {"type": "spot", "spot": {"innerConeAngle": float(np.radians(light.cone.inner)),
                                            "outerConeAngle": float(np.radians(light.cone.outer))}}
    return source


def _place(light: PointLight | DirectionalLight, rotation: np.ndarray) -> dict:
    """The node's transform of a light: its direction is -z."""
    is_point = isinstance(light, PointLight)
    direction = (light.cone and light.cone.direction) if is_point else light.direction
    if direction is None:
        return {"translation": (rotation @ light.position).tolist()}
    back = -(rotation @ direction) / np.linalg.norm(direction)
    side = np.cross(np.eye(3)[np.abs(back).argmin()], back)
    side /= np.linalg.norm(side)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack((side, np.cross(back, side), back), axis=1)
    if is_point:
        matrix[:3, 3] = rotation @ light.position
    return {"matrix": matrix.T.reshape(-1).tolist()}


def _add_view(tree: dict, scene: Scene, rotation: np.ndarray) -> None:
    """Camera and lights as nodes of the scene."""
    nodes = []
    if scene.camera is not None:
        right, up, forward = scene.camera.axes @ rotation.T
        matrix = np.eye(4)
        matrix[:3, :3] = np.stack((right, up, -forward), axis=1)
        matrix[:3, 3] = rotation @ scene.camera.eye
        tree["cameras"] = [{"type": "perspective", "perspective": {
            "yfov": float(np.radians(scene.camera.fov)), "znear": 1e-4 * max(scene.size, 1e-300)}}]
        nodes.append({"name": "camera", "camera": 0, "matrix": matrix.T.reshape(-1).tolist()})
    if scene.lights:
        tree.setdefault("extensions", {})["KHR_lights_punctual"] = {"lights": [
            _light(light) for light in scene.lights]}
        nodes += [{"name": f"light {number}", **_place(light, rotation),
                   "extensions": {"KHR_lights_punctual": {"light": number}}}
                  for number, light in enumerate(scene.lights)]
    tree["scenes"][0]["nodes"] += range(len(tree["nodes"]), len(tree["nodes"]) + len(nodes))
    tree["nodes"] += nodes


def _glb(scene: Scene, path: Path) -> None:
    rotation = rotation_between(scene.up, Y_UP)
    points, corners = _indexed(scene, rotation)
    exported, materials = trimesh.Scene(), []
    for key in sorted(set(zip(scene.material.tolist(), scene.two_sided.tolist(), strict=True))):
        chosen = (scene.material == key[0]) & (scene.two_sided == key[1])
        used, faces = np.unique(_triangles(corners[chosen], scene.is_triangle[chosen]), return_inverse=True)
        name = f"{len(materials)} {scene.materials[key[0]].name}"
        exported.add_geometry(trimesh.Trimesh(points[used], faces.reshape(-1, 3), process=False, validate=False),
                              geom_name=name, node_name=name)
        materials.append(_to_gltf(scene.materials[key[0]], two_sided=key[1]))

    def complete(tree: dict) -> None:
        tree["asset"]["generator"] = "radiosity-engine"
        tree["materials"] = materials
        for mesh, number in zip(tree["meshes"], range(len(materials)), strict=True):
            mesh["primitives"][0]["material"] = number
        _add_view(tree, scene, rotation)
        used = {key for material in materials for key in material["extensions"]} | set(tree.get("extensions", {}))
        tree["extensionsUsed"] = sorted(used)

    path.write_bytes(trimesh.exchange.gltf.export_glb(exported, include_normals=False, tree_postprocessor=complete))


def _mtl(material: Material, name: str) -> str:
    diffuse, transparent = np.array(material.diffuse), np.array(material.transparent)
    transmitted = float(transparent.max())
    if transmitted == 1 and diffuse.any():
        transmitted -= 2.0**-10  # a d of 0 would be that of all channels, and Kd count in none
    is_mirror, bends = max(material.specular) > 0, material.refraction_index > 1 and not material.thin
    illum = (6 if bends else 4) if transmitted else (3 if is_mirror else 1)
    lines = [f"newmtl {name}", f"Kd {_numbers(diffuse / (1 - transmitted) if transmitted < 1 else diffuse)}",
             f"Ks {_numbers(material.specular)}", f"Ke {_numbers(material.emission)}",
             f"Ni {1.0 if material.thin else material.refraction_index!r}", f"d {1 - transmitted!r}", f"illum {illum}"]
    if transmitted:
        lines.append(f"Tf {_numbers(transparent / transmitted)}")
    return "\n".join(lines) + "\n"


def _obj(scene: Scene, path: Path) -> None:
    points, corners = _indexed(scene, rotation_between(scene.up, Y_UP))
    # For other readers blanks end a name, and a backslash continues its line; numbers distinguish equal names.
    names = [re.sub(r"#|\\$", "_", f"{number}_{'_'.join(material.name.split())}") for number, material in
             enumerate(scene.materials)]
    library = path.with_suffix(".mtl")
    check_text_name(library)
    lines = [f"mtllib {library.name}"] + [f"v {_numbers(point)}" for point in points]
    for number, name in enumerate(names):
        chosen = np.flatnonzero(scene.material == number)
        lines.append(f"usemtl {name}")
        for row, is_triangle in zip((corners[chosen] + 1).tolist(), scene.is_triangle[chosen].tolist(), strict=True):
            lines.append("f " + " ".join(map(str, row[:3] if is_triangle else row)))
    # Neither file is replaced before both are written.
    with whole_file(library) as materials, whole_file(path) as part:
        materials.write_text("\n".join(_mtl(material, name) for material, name in
                                       zip(scene.materials, names, strict=True)), encoding="utf-8")
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _ply(scene: Scene, path: Path) -> None:
    points, corners = _indexed(scene, rotation_between(scene.up, Z_UP))
    colours = np.rint(255 * to_srgb([material.diffuse for material in scene.materials])).astype(int)[scene.material]
    lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}",
             *(f"property double {axis}" for axis in "xyz"), f"element face {len(scene)}",
             "property list uchar int vertex_indices",
             *(f"property uchar {channel}" for channel in ("red", "green", "blue")), "end_header"]
    lines += [_numbers(point) for point in points]
    for row, is_triangle, colour in zip(corners.tolist(), scene.is_triangle.tolist(), colours.tolist(), strict=True):
        row = row[:3] if is_triangle else row
        lines.append(" ".join(map(str, [len(row), *row, *colour])))
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def _stl(scene: Scene, path: Path) -> None:
    points, corners = _indexed(scene, rotation_between(scene.up, Z_UP))
    mesh = trimesh.Trimesh(points, _triangles(corners, scene.is_triangle), process=False, validate=False)
    path.write_bytes(mesh.export(file_type="stl"))


def export_scene(scene: Scene, path) -> None:
    """Writes a scene to a .glb, .obj (with an .mtl of the same name beside it), .ply or .stl file, atomically.

    The scene is rotated so that its up is the format's: +y in GLB and OBJ, +z in PLY and STL. GLB holds float32
    vertices, materials (with exact shares in ``extras`` where glTF cannot express them), sides, camera and lights; OBJ
    exact vertices and materials (but a thin sheet's index); PLY exact vertices and diffuse colours; STL float32
    triangles only.
    Quads stay quads; in GLB and STL they are two consecutive triangles, which `load_scene` merges.

    Raises
    ------
    InputError
        The suffix is unknown, the file cannot be written, it is one that the scene was read from, or the name of an
        .mtl is not UTF-8.
    """
    path = Path(path)
    check_inputs_stay(*scene.files, outputs=(path, path.with_suffix(".mtl") if path.suffix.lower() == ".obj" else None))
    writers = dict(zip(FORMATS, (_glb, _obj, _ply, _stl), strict=True))
    suffix = path.suffix.lower()
    if suffix not in writers:
        raise InputError(f"output {str(path)!r}: Name must end in {' or '.join(FORMATS)}, not {path.suffix!r}")
    try:
        if suffix == ".obj":  # two files, each written atomically
            _obj(scene, path)
            return
        with whole_file(path) as part:
            writers[suffix](scene, part)
    except OSError as error:
        raise InputError(f"output {str(path)!r}: cannot be written ({error.strerror or error})") from error
