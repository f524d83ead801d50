import json
import os
import struct
import warnings

import pytest
from PIL import Image

from golden.errors import InputWarning
from golden.scene.gltf_tree import MOST_FACES, MOST_PRIMITIVES, MOST_ZEROS
from golden.scene.load import load_scene
from tb.golden.commands.runner import run
from tb.golden.scene.test_load import BOX, BOX_QUADS, ELL, FORMATS, SQUARE, gltf, obj, ply, refusal, write

SUN = {"KHR_lights_punctual": {"lights": [{"type": "laser", "range": 3}]}}
LIBRARY = "newmtl a\nKd 1 1 1\nKs 1 1 1\nNs 10\nTf 0 0 1\nmap_Bump b.png\nbump b.png\n"
HELD = {
    "line.obj": (SQUARE + "f 1 2 3\nl 1 2\nl 2 3\np 1\n", "not used: 'l' (2), 'p'"),
    "colours.obj": ("v 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "not used: colours of vertices"),
    "flat.obj": (SQUARE + "v 2 0 0\nf 1 2 3 4\nf 1 2 2\nf 1 2 5\n", "not used: face 2 and 1 more have no area"),
    "gone.obj": ("mtllib gone.mtl\n" + SQUARE + "usemtl steel\nf 1 2 3\n",
                 "there is no material library 'gone.mtl': its materials become grey"),
    "edges.ply": (ply(ELL, [tuple(range(6))]).replace(b"end_header", b"element edge 1\nproperty int a\nend_header")
                  + b"7\n", "not used: element edge"),
    "quality.ply": (ply(ELL, [tuple(range(6))], vertex_colours=[(1, 2, 3)] * 6).replace(b"uchar red", b"uchar alpha"),
                    "not used: vertex property alpha, vertex property green, vertex property blue"),
    "coloured.stl": (b"\0" * 80 + struct.pack("<I12fH", 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 31),
                     "not used: attributes of facets"),
}
EXTENSIONS = {"KHR_materials_volume": {"attenuationDistance": 1}, "KHR_materials_ior": {"ior": 1.4}}
TREES = {
    "lights": ({"extensions": SUN}, "not used: laser light, range of a light"),
    "animations": ({"animations": [{}, {}], "skins": [{}]}, "not used: animations (2), skins"),
    "scenes": ({"scenes": [{"nodes": [0]}] * 3}, "not used: scenes beside the first (2)"),
    "extensions": ({"extensionsUsed": ["KHR_materials_ior", "KHR_materials_sheen"]},
                   "not used: extension KHR_materials_sheen"),
    "undeclared": ({"materials": [{"extensions": {"KHR_materials_clearcoat": {}}}]},
                   "not used: extension KHR_materials_clearcoat"),
    "orthographic": ({"cameras": [{"type": "orthographic"}, *[{"perspective": {"yfov": 1}}] * 2]},
                     "not used: cameras beside the first, orthographic camera"),
    "negative": ({"materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0, 2, 0, 1]},
                                 "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": -1}}}]},
                 "not used: negative emissiveStrength, baseColorFactor beyond 0 to 1"),
    "materials": ({"materials": [{"alphaMode": "MASK", "normalTexture": {"index": 0}, "extensions": EXTENSIONS}]},
                  "not used: normalTexture, alphaMode MASK, KHR_materials_volume.attenuationDistance"),
}


@pytest.mark.parametrize("name", HELD)
def test_what_a_file_holds_and_a_scene_does_not_use_is_named_once(tmp_path, name):
    content, says = HELD[name]
    path = write(tmp_path, name, content)
    with pytest.warns(InputWarning) as caught:
        load_scene(path)
    assert [str(warning.message) for warning in caught] == [f"{path}: {says}"]


@pytest.mark.parametrize("case", TREES)
def test_what_a_gltf_file_holds_and_a_scene_does_not_use_is_named_once(tmp_path, case):
    changes, says = TREES[case]
    path = gltf(tmp_path, **changes)
    with pytest.warns(InputWarning) as caught:
        load_scene(path)
    assert [str(warning.message) for warning in caught] == [f"{path}: {says}"]


def test_values_of_a_library_that_are_not_used_are_named(tmp_path):
    write(tmp_path, "a.mtl", LIBRARY)
    path = write(tmp_path, "a.obj", "mtllib a.mtl\nusemtl a\n" + obj(BOX, BOX_QUADS))
    with pytest.warns(InputWarning) as caught:
        load_scene(path)
    assert [str(warning.message) for warning in caught] == [
        f"{path}: a.mtl: not used: 'map_Bump', 'bump', 'Ks' of a highlight, 'Tf' of an opaque material"]


@pytest.mark.parametrize(("line", "says"), [
    ("Kd -1 0.5 0.5", "negative 'Kd'"), ("Ke 1 1 -1", "negative 'Ke'"), ("d 7", "'d' above 1"),
    ("d -1", "negative 'd'"), ("Tr 2", "'Tr' above 1"), ("d -halo 0.3", "'-halo' of 'd'"),
    ("map_Kd -s 2 2 1 -clamp on -bm 0.5 a.png", "'-bm' of 'map_Kd'")])
def test_values_and_options_of_a_library_without_effect_are_named(tmp_path, line, says):
    Image.new("RGB", (2, 2)).save(tmp_path / "a.png")
    write(tmp_path, "a.mtl", f"newmtl a\n{line}\n")
    path = write(tmp_path, "a.obj", "mtllib a.mtl\nusemtl a\n" + SQUARE + "vt 0 0\nf 1/1 2/1 3/1\n")
    with pytest.warns(InputWarning) as caught:
        load_scene(path)
    assert [str(warning.message) for warning in caught] == [f"{path}: a.mtl: not used: {says}"]


def test_a_byte_order_mark_hides_no_first_line(tmp_path):
    write(tmp_path, "a.mtl", "\ufeffnewmtl a\nKe 1 2 3\n")
    scene = load_scene(write(tmp_path, "a.obj", "\ufeffmtllib a.mtl\nusemtl a\n" + SQUARE + "f 1 2 3 4\n"))
    assert scene.materials[0].emission == (1, 2, 3)


@pytest.mark.parametrize("name", FORMATS)
def test_nothing_is_named_where_all_is_used(tmp_path, name):
    with warnings.catch_warnings():
        warnings.simplefilter("error", InputWarning)
        assert len(load_scene(write(tmp_path, name, FORMATS[name](BOX, BOX_QUADS)))) == 6


def test_a_face_without_area_leaves_the_others_as_they_are(tmp_path):
    path = write(tmp_path, "a.obj", SQUARE + "f 1 2 2\nf 1 2 3 4\n")
    with pytest.warns(InputWarning):
        scene = load_scene(path)
    assert scene.areas.tolist() == [1]


def test_strict_makes_a_warning_an_error(tmp_path):
    path, output = write(tmp_path, "a.obj", SQUARE + "f 1 2 3\nl 1 2\n"), tmp_path / "b.ply"
    kind = run("scene", path, "-o", output)
    assert (kind.exit_code, kind.stderr) == (0, f"warning: {path}: not used: 'l'\n")
    output.unlink()
    strict = run("scene", path, "-o", output, "--strict")
    assert (strict.exit_code, strict.stderr) == (2, f"error: {path}: not used: 'l'\n")
    assert not output.exists()


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


@pytest.mark.filterwarnings("ignore::golden.errors.InputWarning")
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
