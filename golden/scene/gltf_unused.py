"""What a glTF file holds and its scene does not use."""

from golden.base.errors import InputError
from golden.scene.gltf_faces import TRIANGLES
from golden.scene.gltf_material import EXACT, MIRROR_ROUGHNESS
from golden.scene.unused import Unused

__all__ = ["check_required", "unused_of"]

LIGHTS = ("point", "spot", "directional")
"""Types of lights that are read."""

USED = {"KHR_lights_punctual": ("lights", "light"), "KHR_materials_transmission": ("transmissionFactor",),
        "KHR_materials_ior": ("ior",), "KHR_materials_volume": ("thicknessFactor",),
        "KHR_materials_emissive_strength": ("emissiveStrength",), "KHR_texture_transform": (),
        "KHR_mesh_quantization": (), "EXT_mesh_gpu_instancing": (), "EXT_texture_webp": ()}
"""Extensions that are read, and those of their members."""

TEXTURES = ("normalTexture", "occlusionTexture")


def check_required(tree: dict) -> None:
    """The extensions that a file requires are read.

    Raises
    ------
    InputError
        One is not.
    """
    for name in tree.get("extensionsRequired", ()):
        if name not in USED:
            raise InputError(f"it requires the extension {name}, which is not read")


def unused_of(tree: dict) -> Unused:
    """What `golden.scene.gltf.read_gltf` skips of a checked file: it does not name tangents."""
    unused = Unused()
    for member in "animations", "skins":
        unused.add(member, len(tree.get(member, ())))
    unused.add("scenes beside the first", max(0, len(tree.get("scenes", ())) - 1))
    lenses = sum("perspective" in camera for camera in tree.get("cameras", ()))
    unused.add("cameras beside the first", max(0, lenses - 1))
    unused.add("orthographic camera", len(tree.get("cameras", ())) - lenses)
    # Some files do not declare all extensions of their parts.
    primitives = [primitive for mesh in tree.get("meshes", ()) for primitive in mesh["primitives"]]
    parts = (tree, *primitives, *(part for kind in ("materials", "nodes", "textures") for part in tree.get(kind, ())))
    for name in dict.fromkeys((*tree.get("extensionsUsed", ()), *(
            name for part in parts for name in part.get("extensions", ())))):
        unused.add(f"extension {name}", name not in USED)
    for primitive in primitives:
        unused.add("points and lines", primitive.get("mode", 4) not in TRIANGLES)
        unused.add("faces without POSITION", primitive.get("mode", 4) in TRIANGLES
                   and "POSITION" not in primitive.get("attributes", {}))
        unused.add("morph targets", bool(primitive.get("targets")))
    for light in tree.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", ()):
        unused.add(f"{light.get('type')} light", light.get("type") not in LIGHTS)
        unused.add("range of a light", "range" in light)
    for material in tree.get("materials", ()):
        _add_material(unused, material)
    return unused


def _add_material(unused: Unused, material: dict) -> None:
    pbr, extensions = material.get("pbrMetallicRoughness", {}), material.get("extensions", {})
    strength = extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1)
    unused.add("negative emissiveStrength", strength < 0)
    unused.add("negative emissiveFactor", min(material.get("emissiveFactor", (0,))) < 0)
    unused.add("negative thicknessFactor", extensions.get("KHR_materials_volume", {}).get("thicknessFactor", 0) < 0)
    unused.add("ior below 1", extensions.get("KHR_materials_ior", {}).get("ior", 1) < 1)
    for name, part in (("metallicFactor", pbr), ("roughnessFactor", pbr),
                       ("transmissionFactor", extensions.get("KHR_materials_transmission", {}))):
        unused.add(f"{name} beyond 0 to 1", not 0 <= part.get(name, 0) <= 1)
    colour = pbr.get("baseColorFactor", (0,))
    unused.add("baseColorFactor beyond 0 to 1", min(colour) < 0 or max(colour) > 1)
    _add_gloss(unused, material, pbr)
    for name in TEXTURES:
        unused.add(name, name in material)
    unused.add("metallicRoughnessTexture", "metallicRoughnessTexture" in pbr)
    unused.add("alphaMode MASK", material.get("alphaMode") == "MASK")
    for name, extension in extensions.items():
        for member in extension if name in USED and isinstance(extension, dict) else ():
            unused.add(f"{name}.{member}", member not in USED[name])


def _add_gloss(unused: Unused, material: dict, pbr: dict) -> None:
    """Counts what mirrors and diffuse surfaces stand for; see `golden.scene.gltf_material.gltf_material`."""
    exact, extensions = material.get("extras"), material.get("extensions", {})
    if isinstance(exact, dict) and exact.get(EXACT):
        return
    metallic, roughness = pbr.get("metallicFactor", 1), pbr.get("roughnessFactor", 1)
    transmits = extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0) > 0
    unused.add("gloss of a rough metal", metallic > 0 and roughness > MIRROR_ROUGHNESS)
    unused.add("roughness of a mirror", metallic > 0 and 0 < roughness <= MIRROR_ROUGHNESS)
    unused.add("roughness of what transmits", metallic < 1 and transmits and roughness > 0)
    unused.add("gloss of a dielectric", metallic < 1 and not transmits and roughness < 1)
