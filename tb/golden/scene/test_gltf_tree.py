"""Each member of a glTF file that the reader uses is refused with its path if it has another type."""

import copy

import pytest

from golden.base.errors import InputError
from golden.scene.gltf_tree import check_tree

COLOUR, NUMBER = "a list of 3 numbers", "a finite number"
# Path: what is wrong there, and what it must be.
WRONG = {
    **{f"materials[0].extras.radiosity_engine.{name}": (value, COLOUR)
       for name in ("diffuse", "specular", "transparent", "emission") for value in ([1, 2],)},
    "materials[0].extras.radiosity_engine.refraction_index": ("1.5", NUMBER),
    "materials[0].extras.radiosity_engine.thin": (1, "true or false"),
    "materials[0].extras.radiosity_engine": ([], "an object"),
    "materials[0].pbrMetallicRoughness.baseColorFactor": ([1, 1, 1], "a list of 4 numbers"),
    "materials[0].pbrMetallicRoughness.roughnessFactor": (None, NUMBER),
    "materials[0].pbrMetallicRoughness.baseColorTexture.texCoord": (-1, "a whole number of at least 0"),
    "materials[0].emissiveFactor": ([1, 1], COLOUR), "materials[0].name": (3, "a string"),
    "materials[0].extensions.KHR_materials_ior.ior": ("2", NUMBER),
    "materials[0].extensions.KHR_materials_volume.thicknessFactor": ([], NUMBER),
    "materials[0].extensions.KHR_materials_transmission.transmissionFactor": (True, NUMBER),
    "materials[0].extensions.KHR_materials_emissive_strength.emissiveStrength": (1e31, NUMBER),
    "nodes[0].matrix": ([1] * 15, "a list of 16 numbers"), "nodes[0].rotation": ([0, 0, 0], "a list of 4 numbers"),
    "nodes[0].scale": (1, COLOUR), "nodes[0].children": (0, "a list"), "nodes[0].camera": (0.0, "a whole number"),
    "extensions.KHR_lights_punctual.lights[0].color": ([1], COLOUR),
    "extensions.KHR_lights_punctual.lights[0].intensity": ("1", NUMBER),
    "extensions.KHR_lights_punctual.lights[0].type": (0, "a string"),
    "extensions.KHR_lights_punctual.lights[0].spot.outerConeAngle": ("1", NUMBER),
    "extensions.KHR_lights_punctual.lights[0].spot.innerConeAngle": (False, NUMBER),
    "cameras[0].perspective.yfov": ([], NUMBER), "accessors[0].count": (-1, "a whole number of at least 0"),
    "textures[0].source": (0.5, "a whole number of at least 0"),
    "meshes[0].primitives[0].extensions": ([], "an object"),
    "samplers[0].wrapT": ("x", "a whole number of at least 0"),
    "buffers[0].uri": (1, "a string"), "images[0].uri": ({}, "a string"), "extensionsRequired[0]": (1, "a string"),
    "scene": (1.0, "a whole number"), "scenes[0].nodes[0]": ("0", "a whole number"),
    "meshes[0].primitives[0].attributes.POSITION": (None, "a whole number"),
    "meshes[0].primitives[0].material": ("0", "a whole number")}
# Members that an object must have.
BESIDE = {"meshes": {"primitives": []}, "accessors": {"count": 1, "componentType": 5126, "type": "VEC3"},
          "buffers": {"byteLength": 0}, "textures": {}, "baseColorTexture": {"index": 0},
          "perspective": {"yfov": 1.0}}


def tree(path, value):
    """An object in which a path leads to a value."""
    *names, last = path.replace("[0]", ".0").split(".")
    for number, name in enumerate(reversed([*names, last])):
        above = [*names, last][-number - 2] if number + 1 < len([*names, last]) else ""
        if name == "0":
            value = [value]
        else:
            inner = [*names, last][-number - 3] if above == "0" else above
            value = {**BESIDE.get(inner, {}), name: value}
    return value


@pytest.mark.parametrize("path", WRONG)
def test_a_member_of_another_type_is_named(path):
    value, requirement = WRONG[path]
    with pytest.raises(InputError) as error:
        check_tree(tree(path, value))
    assert str(error.value) == f"{path} must be {requirement}, not {value!r:.60}"


@pytest.mark.parametrize("extras", [{"radiosity_engine": {"thin": True, "refraction_index": 1, "note": []}}, 3, [], {}])
def test_other_extras_may_hold_anything(extras):
    held = {"materials": [{"extras": copy.deepcopy(extras)}]}
    check_tree(held)
    assert held == {"materials": [{"extras": extras}]}
