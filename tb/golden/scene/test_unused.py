import json
import os
import struct
from base64 import b64encode

import pytest
from PIL import Image

from golden.base.errors import InputWarning
from golden.scene.builtin import builtin_scene
from golden.scene.gltf_tree import MOST_FACES, MOST_PRIMITIVES, MOST_ZEROS
from golden.scene.load import load_scene
from golden.scene.luminaires.luminaire import Luminaire
from tb.golden.scene.files import BOX, BOX_QUADS, ELL, SQUARE, gltf, obj, ply, refusal, write
from tb.golden.scene.luminaires.texts import eulumdat, ies
from tb.radiosity.cli.golden.runner import run

SUN = {"KHR_lights_punctual": {"lights": [{"type": "laser", "range": 3},
                                          {"type": "spot", "spot": {"innerConeAngle": 1, "outerConeAngle": 0.5}}]}}
# glTF's default material is a rough metal.
MATTE = {"pbrMetallicRoughness": {"metallicFactor": 0}}
PASSES = {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.5}}}
EXTENSIONS = {"KHR_materials_volume": {"attenuationDistance": 1}, "KHR_materials_ior": {"ior": 1.4}}
TREES = {
    "lights": ({"extensions": SUN, "nodes": [{"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 1}}}]},
               "not used: laser light, range of a light, innerConeAngle beyond outerConeAngle"),
    "animations": ({"animations": [{}, {}], "skins": [{}]}, "not used: animations (2), skins"),
    "scenes": ({"scenes": [{"nodes": [0]}] * 3}, "not used: scenes beside the first (2)"),
    "extensions": ({"extensionsUsed": ["KHR_materials_ior", "KHR_materials_sheen"]},
                   "not used: extension KHR_materials_sheen"),
    "undeclared": ({"materials": [{**MATTE, "extensions": {"KHR_materials_clearcoat": {}}}],
                    "nodes": [{"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": False}}}]},
                   "not used: extension KHR_materials_clearcoat, extension KHR_node_visibility"),
    "orthographic": ({"cameras": [{"type": "orthographic"}, *[{"perspective": {"yfov": 1}}] * 2]},
                     "not used: cameras beside the first, orthographic camera"),
    "negative": ({"materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0, 2, 0, 1], "metallicFactor": 0},
                                 "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": -1}}}]},
                 "not used: negative emissiveStrength, baseColorFactor beyond 0 to 1"),
    "places": ({"cameras": [{"perspective": {"yfov": 1}}] * 2, "scenes": [{"nodes": list(range(5))}],
                "nodes": [{"mesh": 0}, *({"camera": number} for number in (0, 1, 0, 0))]},
               "not used: cameras beside the first, further places of a camera (2)"),
    "shapeless": ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}, {"attributes": {}}, {}]}]},
                  "not used: faces without POSITION (2)"),
    "beyond": ({"materials": [
        *({"pbrMetallicRoughness": {"metallicFactor": metal, "roughnessFactor": rough}}
          for metal, rough in ((-3, 1), (-1e-9, 1), (0, 2), (0, 1))),
        *({**MATTE, "extensions": {name: {member: value}}} for name, member, value in (
            ("KHR_materials_ior", "ior", 0.5), ("KHR_materials_ior", "ior", 1),
            ("KHR_materials_volume", "thicknessFactor", -1), ("KHR_materials_transmission", "transmissionFactor", -1))),
        {**MATTE, "emissiveFactor": [0, 0, -1]}]},
               "not used: metallicFactor beyond 0 to 1 (2), roughnessFactor beyond 0 to 1, ior below 1, "
               "negative thicknessFactor, transmissionFactor beyond 0 to 1, negative emissiveFactor"),
    "materials": ({"materials": [
        {**MATTE, "alphaMode": "MASK", "normalTexture": {"index": 0}, "extensions": EXTENSIONS}]},
                  "not used: normalTexture, alphaMode MASK, KHR_materials_volume.attenuationDistance"),
    "metals": ({"materials": [*({"pbrMetallicRoughness": {"metallicFactor": metal, "roughnessFactor": rough}}
                                for metal, rough in ((1, 0.26), (0.5, 1), (1, 0.25), (0.1, 0), (0, 1))), {}]},
               "not used: gloss of a rough metal (3), roughness of a mirror, gloss of a dielectric"),
    "gloss": ({"materials": [{"pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": rough}, **more}
                             for rough in (0.9, 1, 0) for more in ({}, PASSES)]},
              "not used: gloss of a dielectric (2), roughness of what transmits (2)"),
    "exact": ({"materials": [{"extras": {"radiosity_engine": {"diffuse": [0.5, 0.5, 0.5]}}, "alphaMode": "MASK"}]},
              "not used: alphaMode MASK"),
    "normals": ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 2}, "indices": 1}]}],
                 "accessors": [{"bufferView": view, "componentType": code, "count": count, "type": kind} for
                               view, code, count, kind in ((0, 5126, 4, "VEC3"), (1, 5123, 6, "SCALAR"),
                                                           (2, 5126, 4, "VEC3"))],
                 "bufferViews": [{"buffer": number, "byteOffset": start, "byteLength": length}
                                 for number, start, length in ((0, 0, 48), (0, 48, 12), (1, 0, 48))],
                 "buffers": [{"byteLength": 60}, {"byteLength": 48, "uri": "data:;base64," + b64encode(
                     struct.pack("<12f", *(0, 0, -1) * 4)).decode()}]},
                "not used: normals that contradict the order of corners (2)"),
    "lines": ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}, {"mode": 1}]}]},
              "not used: points and lines"),
    "corners": ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]},
                "not used: corners of an incomplete triangle"),
    "strip": ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1},
                                          {"attributes": {"POSITION": 0}, "indices": 2, "mode": 5}]}],
               "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                             *({"bufferView": 1, "componentType": 5123, "count": count, "type": "SCALAR"}
                               for count in (6, 2))]},
              "not used: corners of an incomplete triangle (2)"),
    "picture": ({"materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0}}],
                 "textures": [{"source": 0}], "images": [{"uri": "my%20wall.png"}]},
                "there is no picture 'my wall.png': baseColorTexture 0 is not used"),
    "frames": ({"materials": [{**MATTE, "emissiveTexture": {"index": 0}}], "textures": [{"source": 0}],
                "images": [{"uri": "moving.gif"}]},
               "not used: further frames of emissiveTexture, texture of a face without "
               "coordinates (2)"),
    "turned": ({"nodes": [{"mesh": 0, "rotation": [0, 0, 0, 2]}]}, "not used: length of a rotation"),
    "no picture": ({"materials": [{**MATTE, "emissiveTexture": {"index": 0}}], "textures": [{}]},
                   "texture 0 has no picture that can be read: emissiveTexture is not used"),
}
LIBRARIES = {
    "Kd 1 1 1\nKs 1 1 1\nNs 10\nTf 0 0 1\nmap_Bump b.png\nbump b.png":
        "not used: 'map_Bump', 'bump', 'Ks' of a highlight, 'Tf' of an opaque material",
    "Ks 0.1 0.1 0.1\nNs 600": "not used: spread of a highlight", "d 0.5\nNi 1.5": "not used: 'Ni' without refraction",
    "Kd -1 0.5 0.5": "not used: negative 'Kd'", "Ke 1 1 -1": "not used: negative 'Ke'", "d 7": "not used: 'd' above 1",
    "d -1": "not used: negative 'd'", "Tr 2": "not used: 'Tr' above 1", "d -halo 0.3": "not used: '-halo' of 'd'",
    "Kd 0.8 0.1 0.1\nKs 0.5 0 0\nillum 3": "not used: shares beyond a sum of 1",
    "Kd 0 0 0 0": "not used: further values of 'Kd'", "d 1\nTr 1": "not used: 'Tr' that contradicts 'd'",
    "Ni 0": "not used: 'Ni' below 1", "newmtl b\nnewmtl a":
        "a.mtl:3: material 'a' is defined again: the first definition is not used",
    "map_Kd -s 2 2 1 -clamp on -bm 0.5 a.png": "not used: '-bm' of 'map_Kd'",
    "Kd 0 0 0\nmap_Kd a.png -texres 9": "not used: '-texres' of 'map_Kd', 'Kd' of 0 with a picture",
    "map_Kd clear.png": "not used: alpha of 'map_Kd'",
    "map_Kd moving.gif": "not used: further frames of 'map_Kd'",
    "Kd 1 0 0\nKd 0 1 0\nd 1\nd 1": "not used: earlier 'Kd' of a material, earlier 'd' of a material",
    "map_Kd clear.png\nmap_Kd a.png":
        "not used: alpha of 'map_Kd', earlier 'map_Kd' of a material",
    "map_Kd -clamp on": "not used: 'map_Kd' without a name",
    "map_Kd /parts/a.png": "there is no file '/parts/a.png': 'a.png' is taken for it",
    "map_Kd gone away.png": "a.mtl:2: there is no picture 'gone away.png': 'Kd' alone is used",
}
FACE = SQUARE + "f 1 2 3\n"
HEXAGON = ply(ELL, [tuple(range(6))])
FILES = {
    "lines.obj": (FACE + "l 1 2\nl 2 3\np 1\n", "not used: 'l' (2), 'p'"),
    "colours.obj": ("v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "not used: colours of vertices"),
    "weights.obj": ("v 0 0 0 2\nv 1 0 0 1\nv 0 1 0\nf 1 2 3\n", "not used: weights of vertices"),
    "third.obj": (FACE + "vt 0 0 1\nvt 0 0 0\n", "not used: third texture coordinates"),
    "flat.obj": (SQUARE + "v 2 0 0\nf 1 2 3 4\nf 1 2 2\nf 1 2 5\n", "not used: face 2 and 1 more have no area"),
    "gone.obj": ("mtllib gone.mtl\n" + SQUARE + "usemtl steel\nf 1 2 3\n",
                 "there is no material library 'gone.mtl': its materials become grey"),
    "missing.obj": (SQUARE + "usemtl steel\nf 1 2 3\nusemtl wood\nf 1 3 4\n",
                    "there is no material 'steel' and 1 more: faces of it become grey"),
    "comment.obj": ("mtllib b.mtl\nusemtl b # the wall\n" + FACE, "material 'b # the wall' is taken for 'b'"),
    "commented.obj": ("mtllib e.mtl\nusemtl wall\n" + FACE, "material 'wall' is taken for 'wall # east'"),
    "elsewhere.obj": ("mtllib C:\\parts\\b.mtl\nusemtl b\n" + FACE,
                      r"there is no file 'C:\\parts\\b.mtl': 'b.mtl' is taken for it"),
    "own.obj": ("mtllib b.mtl gone.mtl\nusemtl wall\n" + FACE,
                "material library 'own.mtl', which is not named, is used for 'wall'"),
    "again.obj": ("mtllib b.mtl c.mtl\nusemtl b\n" + FACE,
                  "not used: material of a further library with the name of an earlier one"),
    "doubled.obj": ("mtllib b.mtl\nusemtl b\n" + SQUARE + "f 1 2 3 4\nusemtl c\nf 2 3 4 1\n",
                    "not used: faces in the place of an earlier one of another material or picture (1)"),
    "edges.ply": (HEXAGON.replace(b"end_header", b"element edge 1\nproperty int a\nend_header") + b"7\n",
                  "not used: element edge"),
    "quality.ply": (ply(ELL, [tuple(range(6))], vertex_colours=[(1, 2, 3)] * 6).replace(b"uchar red", b"uchar alpha"),
                    "not used: vertex property alpha, vertex property green, vertex property blue"),
    "bright.ply": (ply(ELL, [tuple(range(6))], face_colours=[(1, 1, 2)]).replace(b"uchar red", b"float red").replace(
        b"uchar green", b"float green").replace(b"uchar blue", b"float blue"), "not used: colours beyond 0 to 1"),
    "words.ply": (HEXAGON + b"1 2 3\n", "not used: words behind the last row (3)"),
    "bytes.ply": (ply(ELL, [tuple(range(6))], kind="binary_big_endian") + b"\n", "not used: bytes behind the last row"),
    "strips.ply": (ply(ELL, [], kind="ascii").replace(b"element face 0", b"element tristrips 1")
                   + b"7 0 1 2 -1 4 5 -1\n", "not used: corners of an incomplete triangle (2)"),
    "normals.obj": (SQUARE + "vn 0 0 1\nvn 0 0 -1\nf 1//1 2//2 3//2\nf 1//1 3//1 4//2\nf 1//-1 3//-1 4//-1\n",
                    "not used: normals that contradict the order of corners (2)"),
    "beyond.obj": (SQUARE + "vn 0 0 1\nf 1//1 2//2 3//1\n", "not used: normals of corners that do not exist"),
    "normals.ply": ("ply\nformat ascii 1.0\nelement vertex 3\n" + "".join(
        f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
        + "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        + "0 0 0 0 0 -1\n1 0 0 0 0 -1\n0 1 0 0 0 -1\n3 0 1 2\n",
                    "not used: normals that contradict the order of corners"),
    "normals.stl": (struct.pack("<80xI12fH", 1, 0, 0, -1, *(0, 0, 0), *(1, 0, 0), *(0, 1, 0), 0),
                    "not used: normals that contradict the order of corners"),
    "words.stl": ("solid a\nfacet normal 0 0 -2\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
                  "endfacet\nendsolid\n", "not used: normals that contradict the order of corners"),
    "coloured.stl": (b"\0" * 80 + struct.pack("<I12fH", 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 31),
                     "not used: attributes of facets"),
    "longer.stl": (b"\0" * 80 + struct.pack("<I12fH", 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0) + b"\n",
                   "not used: bytes behind the last facet"),
    "controls.vs3": ("C encl=1\nF 3\nV 1 0 0 0\nV 2 1 0 0 0\nV 3 0 1 0\nS 1 1 2 3 0 0 0 0.5 a\nS 2 3 2 1 0 0 1 1 b\n",
                     "not used: controls, words behind a vertex, combination of a surface"),
    "views.nff": (2 * "v\nfrom 1 0 0\nat 0 0 0\nup 0 0 1\nangle 45\nb 0 0 0\n" + "f 1 1 1 1 1 0 0 1\ns 0 0 0 1\n",
                  "not used: view before the last one, background before the last one, shares beyond a sum of 1"),
    "tilt.ies": (ies(tilt="lamp.txt"), "not used: dependence on the lamp's tilt"),
    "high.ies": (ies(size=(1, 1, 0.2)), "not used: height of the luminous opening"),
    "more.ies": (ies() + "1 2\n", "not used: numbers behind the candela values (2)"),
    "commas.ies": (ies(candela=[(5.5, 6.5, 7)]).replace(".", ","), "its commas are taken for decimal points"),
    "type.ies": (ies(lamp=0.9).replace("IESNA:LM-63-2002", "IES:LM-63-2019"), "not used: type of generation 0.9"),
    "sets.ldt": (eulumdat(sets=3), "not used: sets of lamps beside the first (2)"),
    "more.ldt": (eulumdat() + "5\n", "not used: numbers behind the intensities"),
}
CASES = [*FILES, *TREES, *LIBRARIES]


def named(folder, case):
    """The file of a case, and what is named of it."""
    frames = [Image.new("L", (2, 2), shade) for shade in (0, 255)]
    frames[0].save(folder / "moving.gif", save_all=True, append_images=frames[1:])
    if case in TREES:
        return gltf(folder, **TREES[case][0]), TREES[case][1]
    for name, materials in {"b": "bc", "c": "b", "e": ["wall # east"], "own": ["wall"]}.items():
        write(folder, f"{name}.mtl", "".join(f"newmtl {one}\nKd {k} 0 0\n" for k, one in enumerate(materials)))
    if case in FILES:
        return write(folder, case, FILES[case][0]), FILES[case][1]
    Image.new("RGB", (2, 2)).save(folder / "a.png")
    Image.new("RGBA", (2, 2)).save(folder / "clear.png")
    write(folder, "a.mtl", f"newmtl a\n{case}\n")
    says = LIBRARIES[case]
    return (write(folder, "a.obj", "mtllib a.mtl\nusemtl a\n" + SQUARE + "vt 0 0\nf 1/1 2/1 3/1\n"),
            f"a.mtl: {says}" if says.startswith("not used") else says)


@pytest.mark.parametrize("case", CASES)
def test_what_a_reader_does_not_use_as_the_file_has_it_is_named_and_strictly_refused(tmp_path, case):
    path, says = named(tmp_path, case)
    if path.suffix in (".ies", ".ldt"):
        lamp, room = Luminaire(path=path, place=(0, 0, 1)), builtin_scene("furnace:1")
        with pytest.warns(InputWarning) as caught:
            lamp.scene(room, 1)
        assert [str(warning.message) for warning in caught] == [f"{path}: {says}"]
        return
    output = tmp_path / "out.ply"
    kind = run("scene", path, "-o", output)
    assert (kind.exit_code, kind.stderr) == (0, f"warning: {path}: {says}\n")
    output.unlink()
    strict = run("scene", path, "-o", output, "--strict")
    assert (strict.exit_code, strict.stderr) == (2, f"error: {path}: {says}\n")
    assert not output.exists()


def test_a_byte_order_mark_hides_no_first_line(tmp_path):
    write(tmp_path, "a.mtl", "\ufeffnewmtl a\nKe 1 2 3\n")
    scene = load_scene(write(tmp_path, "a.obj", "\ufeffmtllib a.mtl\nusemtl a\n" + SQUARE + "f 1 2 3 4\n"))
    assert scene.materials[0].emission == (1, 2, 3)
    tree = json.dumps({"asset": {"version": "3"}})
    assert "not of version 2" in refusal(write(tmp_path, "a.gltf", "\ufeff" + tree))


@pytest.mark.parametrize("library", ["d 0.5\nNi 1.5\nillum 4", "Ks 0.1 0.1 0.1\nNs 1000"])
def test_borders_of_what_is_used_are_named_by_nothing(tmp_path, library):
    """Refraction begins with illumination model 4, and the sharpest highlight is a mirror's; normals count from both
    ends.
    """
    write(tmp_path, "a.mtl", f"newmtl a\n{library}\n")
    path = write(tmp_path, "a.obj", "mtllib a.mtl\nusemtl a\n" + SQUARE + "vn 0 0 1\nf 1//-1 2//1 3//1 4//1\n")
    # A warning would be an error.
    assert len(load_scene(path)) == 1


def test_a_face_without_area_leaves_the_others_as_they_are(tmp_path):
    path = write(tmp_path, "a.obj", SQUARE + "f 1 2 2\nf 1 2 3 4\n")
    with pytest.warns(InputWarning):
        scene = load_scene(path)
    assert scene.areas.tolist() == [1]


def test_a_scene_is_not_written_over_itself(tmp_path):
    path = write(tmp_path, "a.obj", obj(BOX, BOX_QUADS))
    result = run("scene", path, "-o", path)
    assert (result.exit_code, result.stderr) == (2, f"error: output {str(path)!r}: it is the input\n")
    assert path.read_text() == obj(BOX, BOX_QUADS)


def test_an_obj_does_not_take_the_library_of_another(tmp_path):
    library = write(tmp_path, "b.mtl", "newmtl a\nKd 1 1 1\n")
    path = write(tmp_path, "a.obj", "mtllib b.mtl\nusemtl a\n" + obj(BOX, BOX_QUADS))
    result = run("scene", path, "-o", tmp_path / "b.obj")
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert "'b.mtl': it is the input" in result.stderr.replace(f"{tmp_path}/", "")
    assert library.read_text() == "newmtl a\nKd 1 1 1\n"
    assert run("scene", path, "-o", tmp_path / "b.glb").exit_code == 0


def claims(text):
    head, _, body = ply(ELL, [tuple(range(6))], kind="binary_little_endian").partition(b"end_header\n")
    return head + text + b"end_header\n" + body


HOSTILE = {
    "list.ply": (claims(b"element a 1\nproperty list int char b\n") + struct.pack("<i", 2**31 - 1),
                 "it ends within its 1 a rows"),
    "rows.ply": (claims(b"element a 1000000000000\nproperty char b\n"),
                 "it ends within its 1000000000000 a rows"),
    "word.ply": (ply(ELL, [tuple(range(6))]) + b"0" * 10**6, None),
    "empty.ply": (claims(b"element a 1000000000000\n"), None),
}


@pytest.mark.filterwarnings("ignore::golden.base.errors.InputWarning")
@pytest.mark.parametrize("name", HOSTILE)
def test_a_text_that_claims_much_takes_no_memory(tmp_path, name):
    content, says = HOSTILE[name]
    path = write(tmp_path, name, content)
    assert refusal(path) == (None if says is None else f"{path}: {says}")


@pytest.mark.parametrize(("changes", "says"), [
    ({"nodes": [{"children": [1, 2]}, {"children": [3]}, {"children": [3]}, {"mesh": 0}]},
     "nodes[3] is a child of both nodes[1] and nodes[2]"),
    ({"nodes": [{"children": [1, 1]}, {"mesh": 0}]}, "nodes[0].children names a node twice"),
    ({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}] * (MOST_PRIMITIVES + 1)}]},
     f"its meshes have {MOST_PRIMITIVES + 1} primitives, at most {MOST_PRIMITIVES} are read"),
    ({"scenes": [{"nodes": [0, 0]}]}, "scenes[0].nodes names a node twice"),
    ({"accessors": [{"componentType": 5126, "count": 10**12, "type": "VEC3"},
                    {"componentType": 5123, "count": 3, "type": "SCALAR"}]},
     f"its accessors claim {10**12 + 3} entries without a buffer, at most {MOST_ZEROS} are read"),
    ({"accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                    {"bufferView": 1, "componentType": 5123, "count": 10**9, "type": "SCALAR"}]},
     f"its meshes have {10**9} corners, at most {3 * MOST_FACES} are read"),
    ({"extensionsRequired": ["EXT_a"]}, "it requires the extension EXT_a, which is not read"),
    ({"meshes": [{"primitives": [{"attributes": {"POSITION": 5}}]}]},
     "meshes[0].primitives[0].POSITION must be the index of one of 2 entries, not 5"),
    ({"nodes": [{"mesh": 3}]}, "nodes[0].mesh must be the index of one of 1 entries, not 3"),
    ({"nodes": [{"mesh": 0, "matrix": [1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}]},
     "nodes[0].matrix must be a matrix with the last row 0, 0, 0, 1, not [0.5, 0, 0, 1]"),
])
def test_a_gltf_file_that_claims_much_is_refused(tmp_path, changes, says):
    path = gltf(tmp_path, **changes)
    assert refusal(path) == f"{path}: {says}"


def test_many_instances_are_refused_before_they_are_made(tmp_path, monkeypatch):
    monkeypatch.setattr("golden.scene.gltf.MOST_FACES", 5)
    path = gltf(tmp_path, nodes=[{"children": [1, 2, 3]}, *[{"mesh": 0}] * 3])
    assert refusal(path) == f"{path}: its nodes instance 6 triangles, at most 5 are read"


@pytest.mark.parametrize(("face", "says"), [
    ("1 2 3 " * 40, "face 1: polygon: it crosses itself"),
    ("1 2 3 4 " * 5000, "face 1 has 20000 corners, at most 16384 are read")])
def test_a_face_that_would_take_long_to_cut_is_refused(tmp_path, face, says):
    path = write(tmp_path, "a.obj", f"{SQUARE}f {face}\n")
    assert refusal(path) == f"{path}: {says}"


@pytest.mark.parametrize("name", ["a.obj", "a.ply", "a.stl", "a.gltf", "a.nff", "a.vs3"])
def test_a_pipe_is_no_scene(tmp_path, name):
    os.mkfifo(tmp_path / name)
    assert refusal(tmp_path / name) == f"{tmp_path / name}: it is not a regular file"


def test_a_pipe_is_no_library_picture_or_buffer(tmp_path):
    for name in "a.mtl", "a.png", "a.bin":
        os.mkfifo(tmp_path / name)
    write(tmp_path, "b.mtl", "newmtl a\nmap_Kd a.png\n")
    tree = {"asset": {"version": "2.0"}, "buffers": [{"byteLength": 1, "uri": "a.bin"}]}
    for name, content in (("a.obj", "mtllib a.mtl\n"), ("b.obj", "mtllib b.mtl\n"), ("a.gltf", json.dumps(tree))):
        message = refusal(write(tmp_path, name, content))
        assert message.startswith(str(tmp_path / name))
        assert "it is not a regular file" in message or "'a.png' cannot be read" in message
