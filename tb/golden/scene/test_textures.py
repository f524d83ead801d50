"""Colours of pictures at points of patches, and which patches have them."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from golden.base.errors import InputError, InputWarning
from golden.scene.appearance import from_srgb
from golden.scene.halve import halved
from golden.scene.load import load_scene
from golden.scene.refine import refine
from golden.scene.texture import Texture
from golden.scene.textures import FaceTextures, Textures, face_mappings
from tb.golden.scene.files import gltf, write
from tb.lib.schedules import SETTINGS

RANDOM = np.random.default_rng(11).integers(0, 256, (8, 16, 3)).astype(np.uint8)
LINEAR = from_srgb(RANDOM / 255)
CORNERS = np.array([(0, 0, 0), (3, 0, 0), (3, 2, 0), (0, 2, 0.0)])


def picture(**wrap):
    return Texture(Image.fromarray(RANDOM), **wrap)


def centre(row, column):
    """Texture coordinates of a texel's centre."""
    return (column + 0.5) / 16, 1 - (row + 0.5) / 8


def texel(place, count, wrap):
    """The texel of a picture's row that stands at a place of the endless row."""
    if wrap == "clamp":
        return min(max(place, 0), count - 1)
    lap, within = divmod(place, count)
    return count - 1 - within if wrap == "mirror" and lap % 2 else within


@settings(SETTINGS, max_examples=100)
@given(eighths=st.tuples(st.integers(-300, 300), st.integers(-150, 150)),
       wrap=st.tuples(*[st.sampled_from(("repeat", "clamp", "mirror"))] * 2))
def test_the_colour_is_bilinear_between_texels_within_the_picture_at_its_borders_and_beyond(eighths, wrap):
    """At eighths of texels: on their centres, their edges and between, up to more than one picture away."""
    across, down = (value / 8 for value in eighths)
    expected = np.zeros(3)
    for row in (np.floor(down - 0.5), np.floor(down - 0.5) + 1):
        for column in (np.floor(across - 0.5), np.floor(across - 0.5) + 1):
            share = (1 - abs(across - 0.5 - column)) * (1 - abs(down - 0.5 - row))
            expected += share * LINEAR[texel(int(row), 8, wrap[1]), texel(int(column), 16, wrap[0])]
    found = picture(wrap=wrap).at(np.array([(across / 16, 1 - down / 8)]))
    assert found[0] == pytest.approx(expected, abs=1e-12)


def test_mappings_reach_every_point_of_faces():
    rng = np.random.default_rng(3)
    counts = np.array([3, 5, 4, 3])
    angles = np.concatenate([2 * np.pi * np.arange(count) / count for count in counts])
    axes = rng.normal(size=(4, 2, 3)) * [[[1]], [[10]], [[0.1]], [[1]]]
    face = np.repeat(np.arange(4), counts)
    offset = rng.normal(size=(4, 3))
    points = offset[face] + np.cos(angles)[:, None] * axes[face, 0] + np.sin(angles)[:, None] * axes[face, 1]
    linear = rng.normal(size=(4, 2, 2))
    uv = np.array([3, -2]) + np.einsum("cxk,ck->cx", linear[face], np.stack([np.cos(angles), np.sin(angles)], axis=1))
    mapping, is_affine = face_mappings(points, uv, counts)
    assert is_affine.all()
    for number in range(4):
        inside = offset[number] + 0.3 * axes[number, 0] - 0.2 * axes[number, 1]
        assert mapping[number] @ [*inside, 1] == pytest.approx(linear[number] @ [0.3, -0.2] + [3, -2], abs=1e-9)


def test_a_thin_triangle_has_its_coordinates_at_all_corners():
    points = np.array([(0, 0, 5), (1, 0, 5), (0.4, 1e-5, 5)])
    uv = np.array([(0, 0), (1, 0), (0.3, 0.8)])
    mapping, is_affine = face_mappings(points, uv, np.array([3]))
    assert is_affine.all()
    assert np.column_stack([points, np.ones(3)]) @ mapping[0].T == pytest.approx(uv, abs=1e-4)


def test_a_bent_face_has_no_picture_and_is_counted():
    textures = FaceTextures()
    uv = np.array([(0, 0), (1, 0), (0.7, 0.7), (0, 1)])
    textures.add(picture(), np.array([0]), points=CORNERS, uv=uv, counts=np.array([4]), colour=np.full((1, 3), 0.5))
    assert textures.bent == 1
    assert textures.build(1).picture.tolist() == [-1]
    assert FaceTextures().build(1) is None


def test_pictures_beyond_the_limit_are_counted(monkeypatch):
    monkeypatch.setattr("golden.scene.textures.MOST_KEPT", 255)
    textures, one = FaceTextures(), picture()
    for texture, count in ((one, 2), (picture(), 3), (one, 1)):
        textures.add(texture, np.arange(count), points=np.tile(CORNERS[:3], (count, 1)),
                     uv=np.zeros((3 * count, 2)), counts=np.full(count, 3), colour=np.ones((count, 3)))
    assert textures.beyond == 3
    assert len(textures.build(3).pictures) == 1


def test_faces_keep_their_pictures_whichever_was_added_last():
    textures, one, other = FaceTextures(), picture(), picture(wrap=("clamp", "clamp"))
    for number, texture in enumerate((one, other, one)):
        textures.add(texture, np.array([number]), points=CORNERS[:3], uv=CORNERS[:3, :2], counts=np.array([3]),
                     colour=np.ones((1, 3)))
    built = textures.build(4)
    assert built.picture.tolist() == [0, 1, 0, -1]
    assert built.pictures == (one, other)


SQUARE = "v 0 0 0\nv 3 0 0\nv 3 2 0\nv 0 2 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"


def painted(folder, faces, *, grain=1):
    pixels = np.kron(RANDOM, np.ones((grain, grain, 1), dtype=np.uint8))
    Image.fromarray(pixels).save(folder / "p.png")
    write(folder, "a.mtl", "newmtl a\nKd 1 1 1\nmap_Kd p.png\nnewmtl b\nKd 0.25 0.25 0.25\n")
    return load_scene(write(folder, "a.obj", "mtllib a.mtl\n" + SQUARE + "usemtl a\n" + faces))


@pytest.mark.filterwarnings("ignore:.*is defined again")
def test_a_definition_that_is_replaced_leaves_nothing(tmp_path):
    Image.fromarray(RANDOM).save(tmp_path / "p.png")
    write(tmp_path, "a.mtl", "newmtl a\nKe 1 1 1\nmap_Kd p.png\nnewmtl a\nKd 0.25 0.25 0.25\n")
    scene = load_scene(write(tmp_path, "a.obj", "mtllib a.mtl\n" + SQUARE + "usemtl a\nf 1/1 2/2 3/3 4/4\n"))
    assert scene.textures is None
    assert scene.channels("diffuse").tolist() == [[0.25, 0.25, 0.25]]
    assert not scene.channels("emission").any()


def inside(scene, patch=0, count=2000, seed=1):
    u, v = np.random.default_rng(seed).random((2, count))
    a, b, c, d = scene.vertices[patch]
    u, v = u[:, None], v[:, None]
    return (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d


@pytest.mark.parametrize("faces", ["f 1/1 2/2 3/3 4/4\n", "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"])
def test_a_patch_shows_the_picture_at_its_place(tmp_path, faces):
    scene = painted(tmp_path, faces)
    assert len(scene) == 1
    rows, columns = (axis.ravel() for axis in np.mgrid[:8, :16])
    u, v = centre(rows, columns)
    ratio = scene.textures.ratio(np.zeros(128, dtype=int), np.column_stack([3 * u, 2 * v, 0 * u]))
    assert scene.channels("diffuse")[0] * ratio == pytest.approx(LINEAR.reshape(-1, 3), abs=1e-9)


def test_halves_on_which_the_picture_is_turned_differently_stay_two_patches(tmp_path):
    turned = painted(tmp_path, "f 1/1 2/2 3/3\nf 1/3 3/1 4/2\n")
    assert len(turned) == 2
    position = np.array([(2, 1, 0), (1, 1, 0.0)])
    found = turned.channels("diffuse") * turned.textures.ratio(np.arange(2), position)
    # The corners (0, 0), (3, 2) and (0, 2) of the second half are at (1, 1), (0, 0) and (1, 0).
    assert found == pytest.approx(picture().at(np.array([(2 / 3, 0.5), (2 / 3, 0.5)])), abs=1e-9)


@pytest.mark.parametrize("halves", [False, True])
@pytest.mark.parametrize("turn", range(4))
@pytest.mark.parametrize("order", [(1, 2, 3, 4), (3, 2, 1, 4)])
def test_two_faces_back_to_back_show_their_own_pictures(tmp_path, order, turn, halves):
    """The front has the corners 1 to 4 at the coordinates 1 to 4; at equal ones the back is that of the front."""
    corners = (3, 2, 1, 4)
    sides = [list(zip(range(1, 5), range(1, 5), strict=True)), list(zip(corners, np.roll(order, turn), strict=True))]
    faces = [side[:1] + side[k:k + 2] for side in sides for k in (1, 2)] if halves else sides
    scene = painted(tmp_path, "".join(f"f {' '.join(f'{v}/{vt}' for v, vt in face)}\n" for face in faces))
    is_alike = (order, turn) == (corners, 0)
    assert len(scene) == (1 if is_alike else 2)
    assert scene.two_sided.tolist() == ([True] if is_alike else [False, False])
    position, uv = np.array([(0.4, 0.3, 0.0)]), np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
    for patch, side in enumerate(sides[:len(scene)]):
        at = dict(side)
        origin, along, across = (uv[at[corner] - 1] for corner in (1, 2, 4))
        expected = picture().at((origin + 0.4 / 3 * (along - origin) + 0.3 / 2 * (across - origin))[None])
        found = scene.channels("diffuse")[[patch]] * scene.textures.ratio(np.array([patch]), position)
        assert found == pytest.approx(expected, abs=1e-9)


def test_a_face_in_the_place_of_one_with_another_picture_is_named(tmp_path):
    with pytest.warns(InputWarning, match=r"in the place of an earlier one of another material or picture \(1\)$"):
        assert len(painted(tmp_path, "f 1/1 2/2 3/3 4/4\nf 1/1 2/2 3/3 4/4\nf 1/3 2/4 3/1 4/2\n")) == 1


def test_halves_of_a_flat_quad_whose_picture_is_bent_stay_two_patches(tmp_path):
    text = "vt 0.7 0.7\n"
    assert len(painted(tmp_path, text + "f 1/1 2/2 3/5\nf 1/1 3/5 4/4\n")) == 2


def test_a_bent_quad_has_its_mean_and_is_named(tmp_path):
    with pytest.warns(InputWarning, match=r"not used: texture coordinates that are not affine on a face$"):
        scene = painted(tmp_path, "vt 0.7 0.7\nf 1/1 2/2 3/5 4/4\n")
    assert scene.textures.picture.tolist() == [-1]


def test_faces_without_a_picture_have_the_ratio_one(tmp_path):
    scene = painted(tmp_path, "f 1/1 2/2 3/3 4/4\nv 0 0 1\nv 1 0 1\nv 1 1 1\nusemtl b\nf -3 -2 -1\n")
    assert scene.textures.picture.tolist() == [0, -1]
    points = np.array([(0.1, 0.1, 0), (0.5, 0.2, 1.0)])
    assert scene.textures.ratio(np.array([0, 1]), points)[1].tolist() == [1, 1, 1]
    assert scene.textures.mean_ratio(np.array([1]), scene.vertices[[1]]).tolist() == [[1, 1, 1]]


def test_parts_have_the_means_of_their_part_of_the_picture(tmp_path):
    scene = painted(tmp_path, "f 1/1 2/2 3/3 4/4\n", grain=16)
    parts = refine(scene, max_edge=0.5).scene
    assert len(parts) > 12
    ratio = parts.textures.mean_ratio(np.arange(len(parts)), parts.vertices)
    assert parts.areas @ ratio / parts.areas.sum() == pytest.approx(1, abs=0.02)
    for number in (0, 7, len(parts) - 1):
        near = inside(parts, number)
        drawn = parts.textures.ratio(np.full(len(near), number), near).mean(axis=0)
        assert ratio[number] == pytest.approx(drawn, rel=0.05)


@pytest.mark.parametrize("corners", [[(0, 0), (3, 0), (3, 2), (0, 0.2)], [(0, 0), (3, 0), (0.5, 2), (0, 2)],
                                     [(0, 0), (3, 0), (3, 2), (3, 2)]])
def test_halves_of_a_part_count_by_their_areas(tmp_path, corners):
    scene = painted(tmp_path, "f 1/1 2/2 3/3 4/4\n")
    part = np.array([(x, y, 0) for x, y in corners], dtype=float)
    halves = part[[[0, 1, 2], [0, 2, 3]]]
    areas = np.cross(halves[:, 1] - halves[:, 0], halves[:, 2] - halves[:, 0])[:, 2]
    expected = areas @ picture().means(halves[..., :2] / (3, 2)) / areas.sum()
    found = scene.textures.mean_ratio(np.array([0]), part[None])[0] * scene.channels("diffuse")[0]
    assert found == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("cut", [lambda scene: refine(scene, max_edge=0.7).scene, lambda scene: halved(scene, 9),
                                 lambda scene: scene.with_parts(np.array([1, 0, 1]))])
def test_parts_of_patches_show_the_same_places(tmp_path, cut):
    scene = painted(tmp_path, "f 1/1 2/2 3/3 4/4\nv 0 0 1\nv 1 0 1\nv 1 1 1\nf -3/3 -2/1 -1/2\n")
    parts = cut(scene)
    assert len(parts.textures) == len(parts) > 2
    whole = np.where(parts.centres[:, 2] > 0.5, 1, 0)
    assert parts.textures.ratio(np.arange(len(parts)), parts.centres) == pytest.approx(
        scene.textures.ratio(whole, parts.centres))


def test_a_scene_has_pictures_for_all_of_its_patches(tmp_path):
    scene = painted(tmp_path, "f 1/1 2/2 3/3 4/4\n")
    with pytest.raises(InputError, match="Textures must have one entry for each of 1 patches, not 2"):
        replace(scene, textures=scene.textures.of(np.array([0, 0])))


def test_pairs_are_alike_in_picture_and_coordinates():
    mapping = np.zeros((4, 2, 4))
    mapping[:, 0, 0] = mapping[:, 1, 1] = 1
    mapping[2, 1, 3] = 0.5
    textures = Textures(pictures=(picture(), picture()), picture=np.array([0, 0, 0, 1]), mapping=mapping,
                        colour=np.ones((4, 3)))
    one, other = np.array([0, 0, 0]), np.array([1, 2, 3])
    assert textures.alike(one, other, np.tile(CORNERS, (3, 1, 1))).tolist() == [True, False, False]
    bare = replace(textures, picture=np.array([-1, -1, -1, -1]))
    assert bare.alike(one, other, np.tile(CORNERS, (3, 1, 1))).all()


def test_pictures_of_gltf_have_factors_and_colours_of_vertices_and_move_with_nodes(tmp_path):
    Image.fromarray(RANDOM).save(tmp_path / "picture.png")
    uv = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype="<f4")
    tint = np.tile(np.array([0.5, 1, 0.25], dtype="<f4"), (4, 1))
    (tmp_path / "more.bin").write_bytes(uv.tobytes() + tint.tobytes())
    base = {"baseColorTexture": {"index": 0}, "baseColorFactor": [1, 0.5, 0.8, 1], "metallicFactor": 0}
    accessors = [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                 {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
                 {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"},
                 {"bufferView": 3, "componentType": 5126, "count": 4, "type": "VEC3"}]
    views = [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12},
             {"buffer": 1, "byteLength": 32}, {"buffer": 1, "byteOffset": 32, "byteLength": 48}]
    path = gltf(tmp_path, materials=[{"pbrMetallicRoughness": base}], textures=[{"source": 0}],
                images=[{"uri": "picture.png"}], accessors=accessors, bufferViews=views,
                buffers=[{"byteLength": 60}, {"byteLength": 80, "uri": "more.bin"}],
                nodes=[{"mesh": 0, "translation": [5, 0, 0], "scale": [2, 1, 1]}, {"mesh": 0}],
                scenes=[{"nodes": [0, 1]}],
                meshes=[{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 2, "COLOR_0": 3}, "indices": 1,
                                         "material": 0}]}])
    scene = load_scene(path)
    first = np.array([bounds.min(axis=0) for bounds in scene.vertices])
    size = np.ptp(scene.vertices, axis=1)
    rows, columns = np.array([1, 6]), np.array([3, 12])
    u, v = (np.array(part) for part in centre(7 - rows, columns))  # v of glTF points downwards
    assert len(scene.textures.pictures) == 1
    for patch in range(len(scene)):
        spread = size[patch] * np.column_stack([u, v, 0 * u])
        ratio = scene.textures.ratio(np.full(2, patch), first[patch] + spread)
        expected = LINEAR[rows, columns] * [0.5, 0.5, 0.2]
        assert scene.channels("diffuse")[patch] * ratio == pytest.approx(expected, abs=1e-6)


@pytest.mark.filterwarnings("ignore:.*'Kd' of 0 with a picture$")
def test_a_picture_is_seen_on_a_material_that_is_black_without_it(tmp_path):
    """As some programs write it; other colours multiply the picture's."""
    found = []
    for kd in ("1 1 1", "0 0 0", "0.5 0 0.5"):
        Image.fromarray(RANDOM).save(tmp_path / "p.png")
        write(tmp_path, "a.mtl", f"newmtl a\nKd {kd}\nmap_Kd p.png\n")
        scene = load_scene(write(tmp_path, "a.obj", "mtllib a.mtl\n" + SQUARE + "usemtl a\nf 1/1 2/2 3/3 4/4\n"))
        found.append(scene.channels("diffuse")[0])
    assert found[0].min() > 0.1
    assert found[1] == pytest.approx(found[0])
    assert found[2] == pytest.approx(found[0] * (0.5, 0, 0.5))
