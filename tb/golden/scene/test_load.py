import struct

import numpy as np
import pytest
import trimesh

from golden.base.errors import InputError, InputWarning
from golden.scene.load import load_scene
from tb.golden.scene.files import BOX, BOX_QUADS, ELL, FORMATS, SQUARE, fans, gltf, obj, ply, refusal, write


def grid_quads(count):
    number = np.arange((count + 1) ** 2).reshape(count + 1, count + 1)
    points = [(0.1 * i, 0.1 * j, 0.5) for i in range(count + 1) for j in range(count + 1)]
    quads = np.stack((number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]), axis=2).reshape(-1, 4)
    return points, [tuple(quad) for quad in quads.tolist()]


@pytest.mark.parametrize("name", FORMATS)
@pytest.mark.parametrize("shape", ["box", "grid"])
def test_every_quad_of_a_file_survives(tmp_path, name, shape):
    points, quads = (BOX, BOX_QUADS) if shape == "box" else grid_quads(17)
    scene = load_scene(write(tmp_path, name, FORMATS[name](points, quads)))
    assert len(scene) == len(quads)
    assert not scene.is_triangle.any()
    assert len(set(scene.surface)) == (6 if shape == "box" else 1)
    area = 22 if shape == "box" else 2.89
    assert scene.areas.sum() == pytest.approx(area, rel=1e-6)


@pytest.mark.parametrize("name", ["ell.obj", "ell.ply"])
def test_a_concave_polygon_keeps_its_area(tmp_path, name):
    content = obj(ELL, [range(6)]) if name.endswith("obj") else ply(ELL, [tuple(range(6))])
    scene = load_scene(write(tmp_path, name, content))
    assert scene.areas.sum() == pytest.approx(3)
    assert (scene.normals[:, 2] > 0).all()
    assert len(set(scene.surface)) == 1
    # The notch stays open.
    assert not (scene.vertices.mean(axis=1)[:, :2] > 1).all(axis=1).any()


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_text_in_utf_16_needs_no_mark(tmp_path, encoding):
    assert len(load_scene(write(tmp_path, "a.obj", obj(BOX, BOX_QUADS).encode(encoding)))) == 6


def test_patches_at_one_edge_are_smooth_with_none_beyond_a_limit(tmp_path):
    """Their pairs would fill the memory."""
    angle = np.linspace(0, np.pi, 20000)
    points = [(0, 0, 0), (0, 0, 1), *zip(np.cos(angle), np.sin(angle), 0 * angle, strict=True)]
    scene = load_scene(write(tmp_path, "a.obj", obj(points, [(0, 1, 2 + k) for k in range(len(angle))])))
    assert len(scene) == len(set(scene.smooth.tolist())) == len(angle)


def test_a_quad_that_is_not_planar_is_split(tmp_path):
    scene = load_scene(write(tmp_path, "a.obj", obj([(0, 0, 0), (1, 0, 0), (1, 1, 0.3), (0, 1, 0)], [range(4)])))
    assert len(scene) == 2
    assert scene.is_triangle.all()


def test_triangles_among_polygons_stay_triangles(tmp_path):
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0)]
    scene = load_scene(write(tmp_path, "a.obj", obj(points, [(0, 1, 2, 3), (1, 4, 5), (1, 5, 2)])))
    assert scene.is_triangle.tolist() == [False, True, True]


def test_faces_over_an_edge_below_the_crease_are_smooth(tmp_path):
    angle = np.linspace(0, 2 * np.pi, 25)[:-1]
    points = [(x, y, z) for z in (0, 1) for x, y in zip(np.cos(angle), np.sin(angle), strict=True)]
    faces = [(k, (k + 1) % 24, 24 + (k + 1) % 24, 24 + k) for k in range(24)] + [tuple(range(24, 48))]
    scene = load_scene(write(tmp_path, "a.obj", obj(points, faces)))
    assert len(set(scene.smooth[:24])) == 1
    assert len(set(scene.smooth)) == 2
    assert len(set(scene.surface)) == 25


def test_a_library_of_another_folder_may_have_a_path_of_another_system(tmp_path):
    (tmp_path / "parts").mkdir()
    write(tmp_path / "parts", "a.mtl", "newmtl red\nKd 1 0 0\n")
    scene = load_scene(write(tmp_path, "a.obj", "mtllib parts\\a.mtl\nusemtl red\n" + obj(BOX, BOX_QUADS)))
    assert [material.diffuse for material in scene.materials] == [(1, 0, 0)]


@pytest.mark.parametrize("faces", [BOX_QUADS, fans(BOX_QUADS)])
@pytest.mark.parametrize("reverse", [False, True])
def test_glass_bodies_look_outwards_however_they_are_wound(tmp_path, faces, reverse):
    write(tmp_path, "a.mtl", "newmtl glass\nd 0\nNi 1.5\nillum 6\n")
    faces = [face[::-1] for face in faces] if reverse else faces
    # One face on its own is no body: its side stays as it is.
    points = [*BOX, (9, 0, 0), (10, 0, 0), (9, 1, 0)]
    content = "mtllib a.mtl\nusemtl glass\n" + obj(points, [*faces, (8, 9, 10)])
    scene = load_scene(write(tmp_path, "a.obj", content))
    outward = scene.vertices.mean(axis=1) - (1, 1.5, 0.5)
    assert (np.einsum("ij,ij->i", outward, scene.normals)[:6] > 0).all()
    assert scene.normals[6].tolist() == [0, 0, 1]
    assert scene.is_triangle[6]


def test_ply_face_and_vertex_colours_become_materials(tmp_path):
    points, quads = grid_quads(2)
    by_face = load_scene(write(tmp_path, "a.ply", ply(points, quads, face_colours=[(255, 0, 0)] * 3 + [(0, 0, 255)])))
    assert by_face.channels("diffuse").tolist() == [[1, 0, 0]] * 3 + [[0, 0, 1]]
    by_vertex = load_scene(write(tmp_path, "b.ply", ply(points, quads, vertex_colours=[(255, 255, 255)] * 4
                                                        + [(0, 0, 0)] + [(255, 255, 255)] * 4)))
    assert by_vertex.channels("diffuse") == pytest.approx(np.full((4, 3), 0.75), abs=0.005)


def test_the_first_perspective_camera_of_gltf_is_the_scenes(tmp_path):
    nodes = [{"children": [1, 2, 3, 4]}, {"camera": 0, "translation": [0, 0, 7]},
             {"camera": 1, "translation": [0, 0, 4]}, {"camera": 2, "translation": [0, 0, 9]}, {"mesh": 0}]
    cameras = [{"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 9, "znear": 0.1}},
               *({"type": "perspective", "perspective": {"yfov": np.radians(angle), "znear": 0.1}}
                 for angle in (30, 60))]
    with pytest.warns(InputWarning, match="cameras beside the first"):
        camera = load_scene(gltf(tmp_path, nodes=nodes, cameras=cameras)).camera
    assert (camera.eye, camera.fov) == (pytest.approx((0, 0, 4)), pytest.approx(30))


BAD = {
    "no corner number": ("a.obj", SQUARE + "f 1 2 x\n", ":5: 'x' is not a corner of a face"),
    "corner out of range": ("a.obj", SQUARE + "f 1 2 9\n",
                            ":5: face 1 has a corner at vertex 9, but there are 4 vertices so far"),
    "corner zero": ("a.obj", SQUARE + "f 0 1 2\n",
                    ":5: face 1 has a corner at vertex 0, but there are 4 vertices so far"),
    "corner too far back": ("a.obj", SQUARE + "f -5 -1 -2\n",
                            ":5: face 1 has a corner at vertex -5, but there are 4 vertices so far"),
    "two corners": ("a.obj", SQUARE + "f 1 2\n", ":5: face 1 has 2 corners, three at least are needed"),
    "vertex not a number": ("a.obj", "v 0 0 zero\n", ":1: '0 0 zero' is not a vertex"),
    "vertex with two": ("a.obj", "v 0 0\n", ":1: '0 0' is not a vertex"),
    "NaN vertex": ("a.obj", "v 0 0 nan\n", ":1: vertex 1 is not finite: 0 0 nan"),
    "vertex astray": ("a.obj", SQUARE + "v 0 1e300 0\nf 1 2 5\n", ": vertex 5 is beyond 1e+30: 0 1e+300 0"),
    "infinite vertex": ("a.obj", SQUARE + "v 0 1e999 0\n", ":5: vertex 5 is not finite: 0 1e999 0"),
    "no faces": ("a.obj", SQUARE, ": it has no faces"),
    "empty file": ("a.obj", "", ": it has no faces"),
    "no area": ("a.obj", SQUARE + "f 1 2 2\n", ": face 1 has no area"),
    "many without area": ("a.obj", SQUARE + "v 2 0 0\nf 1 2 2\nf 1 2 5\n", ": face 1 and 1 more have no area"),
    "crossed polygon": ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 0.5 2 0\nf 1 2 3 4 5\n",
                        ": face 1: polygon: it crosses itself"),
    "crossed quad": ("a.obj", "v 0 0 0\nv 4 0 0\nv 0 3 0\nv 3.9 3 0\nf 1 2 3 4\n",
                     ": face 1: polygon: it crosses itself"),
    "no PLY": ("a.ply", "hello\n", ": not a PLY file"),
    "PLY type": ("a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n",
                 ":4: 'property quad x' is not a PLY header line"),
    "PLY without faces": ("a.ply", ply(ELL, []), ": it has no faces"),
    "short text PLY": ("a.ply", ply(ELL, [tuple(range(6))])[:-8], ": it ends within its 1 face rows"),
    "short binary PLY": ("a.ply", ply(ELL, [tuple(range(6))], kind="binary_little_endian")[:-8],
                         ": it ends within its 1 face rows"),
    "PLY word": ("a.ply", ply(ELL, [tuple(range(6))]).replace(b"0 0 0", b"0 0 o", 1),
                 ": a value in its vertex rows is not a number of its type"),
    "PLY corner": ("a.ply", ply(ELL, [(0, 1, 2), (0, 1, 6)]),
                   ": face 2 has a corner at vertex 7, but there are 6 vertices"),
    "PLY colours at a corner that is not there": (
        "a.ply", ply(ELL, [(0, 1, 2), (0, 1, 6)], vertex_colours=[(1, 2, 3)] * 6),
        ": face 2 has a corner at vertex 7, but there are 6 vertices"),
    "PLY negative corner": ("a.ply", ply(ELL, [(0, 1, -1)], kind="binary_big_endian"),
                            ": face 1 has a corner at a negative number, -1, but there are 6 vertices"),
    "PLY NaN": ("a.ply", ply([*ELL[:5], (0, 2, "nan")], [tuple(range(6))]), ": vertex 6 is not finite: 0 2 nan"),
    "PLY with lists for coordinates": (
        "a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
        "property list uchar float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 1 0\n3 0 0 0\n", ": its vertices have no x, y, z"),
    "PLY without vertices": (
        "a.ply", "ply\nformat ascii 1.0\nelement vertex 0\n" + "".join(
            f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
        + "element face 1\nproperty list uchar int vertex_indices\nend_header\n3 0 1 2\n", ": it has no vertices"),
    "PLY with a property twice": ("a.ply", ply(ELL, [tuple(range(6))]).replace(b"float y", b"float x"),
                                  ":6: 'property float x' is not a PLY header line"),
    "PLY with a long list": ("a.ply", ply(ELL, [tuple(range(6))]).replace(b"\n6 0 1", b"\n4000000000 0 1"),
                             ": it ends within its 1 face rows"),
    "library with a zero byte": ("a.obj", "mtllib a\0b.mtl\n" + SQUARE + "f 1 2 3\n",
                                 ":1: material library 'a\\x00b.mtl' cannot be read (embedded null byte)"),
    "PLY face of two": ("a.ply", ply(ELL, [(0, 1)]), ": face 1 has 2 corners, three at least are needed"),
    "empty STL": ("a.stl", b"", ": it has no faces"),
    "STL of words": ("a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex x y z\n"
                     "endloop\nendfacet\nendsolid a\n",
                     ": not a readable STL file (facet 1: 'x' is not a number)"),
    "short binary STL": ("a.stl", b"\0" * 80 + struct.pack("<I", 5) + b"\0" * 50,
                         ": not a readable STL file (it is 134 bytes long and should be 334)"),
    "flat STL": ("a.stl", b"\0" * 80 + struct.pack("<I", 1) + b"\0" * 50, ": face 1 has no area"),
    "no GLB": ("a.glb", b"this is not a GLB file", ": not a readable GLB file (it does not start like one)"),
    "old GLB": ("a.glb", struct.pack("<4s4I", b"glTF", 1, 20, 0, 0),
                ": not a readable GLB file (it is version 1, only version 2 is supported)"),
    "short GLB": ("a.glb", struct.pack("<4s4I", b"glTF", 2, 100, 80, 0x4E4F534A),
                  ": not a readable GLB file (it is 20 bytes long and should be 100)"),
    "glTF that is no JSON": ("a.gltf", "{", ": not a readable GLTF file (Expecting property name enclosed in double "
                             "quotes: line 1 column 2 (char 1))"),
    "glTF of other JSON": ("a.gltf", "[1]", ": not a readable GLTF file (it is not of version 2)"),
    "glTF without nodes": ("a.gltf", '{"asset": {"version": "2.0"}}', ": it has no faces"),
    "packed glTF": ("a.gltf", '{"asset": {"version": "2.0"}, "extensionsUsed": ["KHR_draco_mesh_compression"]}',
                    ": its geometry is compressed with KHR_draco_mesh_compression, which cannot be read"),
    "wrong suffix": ("a.doc", "x", ": Suffix must be one of .obj .ply .stl .gltf .glb .nff .vs3, not '.doc'"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_file_gives_one_line_that_says_what_and_where(tmp_path, case):
    name, content, message = BAD[case]
    path = write(tmp_path, name, content)
    with pytest.raises(InputError) as error:
        load_scene(path)
    assert str(error.value) == f"{path}{message}"


def test_a_bad_value_in_a_library_is_found_from_the_scene(tmp_path):
    write(tmp_path, "a.mtl", "newmtl a\nKd 1 x 1\n")
    path = write(tmp_path, "a.obj", "mtllib a.mtl\n" + SQUARE + "f 1 2 3\n")
    with pytest.raises(InputError) as error:
        load_scene(path)
    assert str(error.value) == f"{path}:1: a.mtl:2: '1 x 1' is not three finite numbers"


def test_relative_paths_are_named_once(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path, "a.obj", SQUARE + "f 1 2 9\n")
    with pytest.raises(InputError, match=r"^a\.obj:5: face 1 has"):
        load_scene("a.obj")
    gltf(tmp_path, nodes=[{"mesh": 0, "scale": [0, 0, 0]}])
    with pytest.raises(InputError, match=r"^a\.glb: face 1 and 1 more have no area$"):
        load_scene("a.glb")


def test_missing_files_and_directories_are_named(tmp_path):
    with pytest.raises(InputError) as error:
        load_scene(tmp_path / "gone.obj")
    assert str(error.value) == f"{tmp_path / 'gone.obj'}: no such file"
    with pytest.raises(InputError) as error:
        load_scene(tmp_path)
    assert str(error.value) == f"{tmp_path}: it is a directory, not a scene file"


def test_a_gltf_buffer_that_is_not_there_is_one_line(tmp_path):
    files = trimesh.Scene(trimesh.creation.box()).export(file_type="gltf")
    path = write(tmp_path, "model.gltf", files["model.gltf"])
    with pytest.raises(InputError) as error:
        load_scene(path)
    assert str(error.value).startswith(f"{path}: ")
    assert "\n" not in str(error.value)


def test_a_degenerate_gltf_camera_is_an_error_with_the_path(tmp_path):
    cameras = [{"type": "perspective", "perspective": {"yfov": 0, "znear": 0.1}}]
    path = gltf(tmp_path, nodes=[{"camera": 0, "mesh": 0}], cameras=cameras)
    with pytest.raises(InputError) as error:
        load_scene(path)
    assert str(error.value) == f"{path}: camera: Field of view must be between 0 and 180 degrees, not 0.0"


@pytest.mark.parametrize("error", [KeyError, TypeError])
@pytest.mark.parametrize(("name", "function"), [
    *((name, "golden.scene.load.mesh_scene") for name in FORMATS), ("mesh.glb", "golden.scene.gltf._mesh"),
    ("binary.stl", "golden.scene.stl.Mesh"), ("quads.obj", "golden.scene.obj.Mesh"),
    ("text.ply", "golden.scene.ply.Mesh")])
def test_an_internal_error_is_not_reported_as_one_of_the_file(tmp_path, monkeypatch, name, function, error):
    """It must reach the developer as it is: only parsers of other projects may raise anything for a bad file."""
    def broken(*arguments, **more):
        raise error("a bug")

    path = write(tmp_path, name, FORMATS[name](BOX, BOX_QUADS))
    monkeypatch.setattr(function, broken)
    with pytest.raises(error, match="a bug"):
        load_scene(path)


@pytest.mark.parametrize(("changes", "message"), [
    ({"nodes": [{"mesh": 0, "children": [7]}]}, "nodes[0].children must be the index of one of 1 entries, not 7"),
    ({"nodes": [{"mesh": 0, "children": [0]}]}, "its nodes form a cycle"),
    ({"nodes": [3]}, "nodes[0] must be an object, not 3"),
    ({"nodes": [{"mesh": 0, "camera": 0}]}, "nodes[0].camera must be the index of one of 0 entries, not 0"),
    ({"nodes": [{"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}]},
     "nodes[0].extensions.KHR_lights_punctual.light must be the index of one of 0 entries, not 0"),
    ({"cameras": [{"perspective": {}}]}, "cameras[0].perspective.yfov is missing"),
    ({"scene": 2}, "scene must be the index of one of 1 entries, not 2"),
    ({"scenes": {}}, "scenes must be a list, not {}"),
    ({"extensionsUsed": [1]}, "extensionsUsed[0] must be a string, not 1"),
    ({"animations": 5}, "animations must be a list, not 5"),
    ({"skins": ["two"]}, "skins[0] must be an object, not 'two'"),
    ({"asset": 2}, "not a readable GLB file (it is not of version 2)"),
])
def test_a_gltf_member_of_the_wrong_type_is_named(tmp_path, changes, message):
    path = gltf(tmp_path, **changes)
    assert refusal(path).startswith(f"{path}: {message}")


def test_an_extension_that_no_material_has_may_have_any_type(tmp_path):
    matte = {"pbrMetallicRoughness": {"metallicFactor": 0}, "extensions": {"KHR_mesh_quantization": 5}}
    assert len(load_scene(gltf(tmp_path, materials=[matte])))
