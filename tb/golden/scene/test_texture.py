import io
import re

import numpy as np
import pytest
from PIL import Image

from golden.base.errors import InputError, InputWarning
from golden.scene.appearance import from_srgb
from golden.scene.load import load_scene
from golden.scene.texture import MOST_PIXELS, Texture, join_halves
from tb.golden.scene.files import gltf, refusal, write
from tb.radiosity.cli.golden.runner import run

RED, GREEN, BLUE, WHITE = (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 255)
ATLAS = Image.fromarray(np.kron(np.array([[RED, GREEN], [BLUE, WHITE]], dtype=np.uint8),
                                np.ones((8, 8, 1), dtype=np.uint8)))
"""Red and green above, blue and white below."""

CORNERS = {RED: (0, 0.5), GREEN: (0.5, 0.5), BLUE: (0, 0), WHITE: (0.5, 0)}
HALF = 0.5 * np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def triangles(corner, size=0.5):
    """The halves of a square of texture coordinates."""
    quad = np.array(corner) + 2 * size * HALF
    return quad[[[0, 1, 2], [0, 2, 3]]]


@pytest.mark.parametrize("colour", CORNERS)
def test_a_face_has_the_colour_of_its_part_of_an_atlas(colour):
    assert Texture(ATLAS).means(triangles(CORNERS[colour])) == pytest.approx(np.tile(np.array(colour) / 255, (2, 1)))


def test_the_whole_picture_has_its_linear_mean():
    random = np.random.default_rng(5).integers(0, 256, (37, 53, 3)).astype(np.uint8)
    mean = from_srgb(random / 255).reshape(-1, 3).mean(axis=0)
    texture = Texture(Image.fromarray(random))
    assert texture.mean() == pytest.approx(mean, rel=1e-12)
    assert texture.means(triangles((0, 0), 1)).mean(axis=0) == pytest.approx(mean, rel=0.01)
    assert texture.means(triangles((3, -2), 2)).mean(axis=0) == pytest.approx(mean, rel=0.05)


@pytest.mark.parametrize("period", [3, 8])
@pytest.mark.parametrize(("texels", "repeats"), [
    *((None, count) for count in (16, 64, 100, 127, 128, 192, 256, 384, 1000, 2**20)), (128, 1), (1024, 1), (1024, 64)])
def test_lines_count_with_their_share_of_the_area_however_often_they_repeat(period, texels, repeats):
    """Black lines, a texel wide, at one of the four borders of each period; the picture has ``texels``, or a period."""
    tile = np.full((period, period, 3), 255, dtype=np.uint8)
    tile[0] = tile[:, 0] = 0
    count = period * ((texels or 1) // period or 1)
    for turn in range(4):
        picture = np.tile(np.rot90(tile, turn), (count // period, count // period, 1))
        means = Texture(Image.fromarray(picture)).means(triangles((0.0, 0.0), repeats))
        assert means.mean(axis=0) == pytest.approx(np.full(3, (1 - 1 / period)**2), abs=3 * 0.004)


@pytest.mark.parametrize(("kind", "colour"), [("repeat", RED), ("clamp", GREEN), ("mirror", GREEN)])
def test_outside_of_a_picture_its_wrap_counts(kind, colour):
    means = Texture(ATLAS, wrap=(kind, "repeat")).means(triangles((1, 0.5)))
    assert means == pytest.approx(np.tile(np.array(colour) / 255, (2, 1)))


def test_a_triangle_shows_the_share_that_its_area_has_of_each_colour():
    """Half of it is blue, a quarter red and a quarter white."""
    (mean,) = Texture(ATLAS).means(np.array([[(0, 0), (1, 0), (0, 1)]]))
    assert mean == pytest.approx([0.5, 0.25, 0.75], abs=0.01)


def test_coordinates_that_are_none_are_refused():
    with pytest.raises(InputError, match="texture coordinate is not finite"):
        Texture(ATLAS).means(np.full((1, 3, 2), np.nan))


def test_a_picture_larger_than_the_limit_is_refused_before_it_is_decoded(monkeypatch):
    image = Image.new("1", (MOST_PIXELS // 1024 + 1, 1024))
    monkeypatch.setattr(Image.Image, "convert", lambda *given: pytest.fail("it is decoded"))
    with pytest.raises(InputError, match="pixels, at most 67108864 are read"):
        Texture(image)


def test_halves_of_a_square_get_their_mean_and_others_stay():
    square = np.array([[(0, 0, 0), (1, 0, 0), (1, 1, 0)], [(0, 0, 0), (1, 1, 0), (0, 1, 0)],
                       [(0, 1, 0), (1, 1, 0), (0, 3, 0)], [(1, 1, 0), (1, 0, 0), (1, 0, 1)]], dtype=float)
    colours = np.array([[0.0], [1.0], [0.25], [0.75]])
    assert join_halves(square, colours).ravel().tolist() == [0.5, 0.5, 0.25, 0.75]
    assert join_halves(square[1:], colours[1:]).ravel() == pytest.approx([0.5, 0.5, 0.75])


def textured(folder, faces, *, more="", name="a.obj"):
    ATLAS.save(folder / "atlas.png")
    write(folder, "a.mtl", f"newmtl a\nKd 1 1 1\nmap_Kd {more}atlas.png\n")
    uv = "".join(f"vt {u} {v}\n" for corner in CORNERS.values() for u, v in (np.array(corner) + HALF).tolist())
    return write(folder, name, "mtllib a.mtl\n" + SQUARE + uv + "usemtl a\n" + faces)


def test_faces_of_one_material_have_their_own_colours_and_halves_of_a_quad_one(tmp_path):
    path = textured(tmp_path, "f 1/1 2/2 3/7\nf 1/1 3/7 4/8\n")
    scene = load_scene(path)
    assert len(scene) == 1
    path = textured(tmp_path, "f 1/1 2/2 3/3 4/4\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                    "f -4/-4 -3/-3 -2/-2 -1/-1\n", name="b.obj")
    assert load_scene(path).channels("diffuse") == pytest.approx(np.array([RED, WHITE]) / 255, abs=1e-9)


@pytest.mark.parametrize(("options", "colour"), [
    ("-o 0.5 ", WHITE), ("-o 0.5 0.5 0 ", GREEN), ("-s 0.5 -o 0 0.5 ", RED), ("-s 1 -1 1 ", RED),
    ("-clamp on -o 9 ", WHITE)])
def test_options_scale_the_coordinates_and_shift_them_then(tmp_path, options, colour):
    """The face shows the lower left quarter without options."""
    scene = load_scene(textured(tmp_path, "f 1/9 2/10 3/11 4/12\n", more=options))
    assert scene.channels("diffuse") == pytest.approx(np.array([colour]) / 255, abs=1e-9)


@pytest.mark.parametrize(("line", "folder"), [
    ("my map.png -bm 0.1", ""), ('-o 0 0 "my map.png"', ""), ("-texres 9 maps\\my map.png", "maps"),
    ("'my map.png'", "")])
@pytest.mark.filterwarnings("ignore:.*not used. '-(bm|texres)' of 'map_Kd'$")
def test_the_name_of_a_picture_may_have_blanks_quotes_and_options_on_either_side(tmp_path, line, folder):
    (tmp_path / folder).mkdir(exist_ok=True)
    Image.new("RGB", (2, 2), BLUE).save(tmp_path / folder / "my map.png")
    write(tmp_path, "a.mtl", f"newmtl a\nmap_Kd {line}\n")
    scene = load_scene(write(tmp_path, "a.obj", f"mtllib a.mtl\n{SQUARE}vt 0 0\nusemtl a\nf 1/1 2/1 3/1\n"))
    assert scene.channels("diffuse").tolist() == [[0, 0, 1]]


@pytest.mark.parametrize(("mode", "value"), [("I;16", 0x4040), ("I", 0x4040), ("L", 0x40), ("LA", (0x40, 255))])
def test_a_grey_has_its_value_in_whatever_bits(mode, value):
    image = Image.new(mode, (3, 2))
    image.paste(value, (0, 0, 3, 2))
    texture = Texture(image)
    assert texture.mean() == pytest.approx(from_srgb([0x40 / 255] * 3))
    assert not texture.has_alpha


@pytest.mark.parametrize(("image", "says"), [
    (Image.new("F", (2, 2)), "floating-point"), (Image.new("I", (2, 2), 65536), "beyond 16 bits")])
def test_values_that_a_display_does_not_have_are_refused(image, says):
    with pytest.raises(InputError, match=says):
        Texture(image)


@pytest.mark.parametrize("face", ["1 2 3 4", "1/1 2/2 3/3 4"])
def test_a_face_without_all_coordinates_has_the_mean_of_the_picture_and_a_warning(tmp_path, face):
    with pytest.warns(InputWarning, match=r"not used: texture of a face without coordinates$"):
        scene = load_scene(textured(tmp_path, f"f {face}\n"))
    assert scene.channels("diffuse") == pytest.approx(np.full((1, 3), 0.5), abs=0.005)


@pytest.mark.parametrize(("face", "says"), [
    ("1/99 2/1 3/1", "face 1 has texture coordinates 99, but there are 16 so far"),
    ("1/0 2/1 3/1", "face 1 has texture coordinates 0, but there are 16 so far"),
    ("1/x 2/1 3/1", "'1/x' is not a corner of a face")])
def test_texture_coordinates_that_are_not_there_are_refused(tmp_path, face, says):
    assert says in refusal(textured(tmp_path, f"f {face}\n"))


def picture_file(folder, image, *, emits=False, glow=None, shift=(0, 0), has_uv=True, info=None, webp=False, **sampler):
    """A square with a texture, of which it shows the upper left quarter: red. Its coordinates may be shifted.

    With ``glow``, another sampler, it emits the same picture too.
    """
    data = io.BytesIO()
    image.save(data, **({"format": "WEBP", "lossless": True} if webp else {"format": "PNG"}))
    (folder / "picture.png").write_bytes(data.getvalue())
    uv = (np.array([(0, 0), (0.5, 0), (0.5, 0.5), (0, 0.5)]) + shift).astype("<f4")
    (folder / "uv.bin").write_bytes(uv.tobytes())
    info = {"index": 0, **(info or {})}
    material = {"pbrMetallicRoughness": {"metallicFactor": 0, **({} if emits else {"baseColorTexture": info})}}
    if emits or glow:
        material |= {"emissiveTexture": {**info, "index": int(bool(glow))}, "emissiveFactor": [1, 1, 1]}
    accessors = [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                 {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"},
                 {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"}]
    views = [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12},
             {"buffer": 1, "byteLength": 32}]
    texture = {"sampler": 0, **({"extensions": {"EXT_texture_webp": {"source": 0}}} if webp else {"source": 0})}
    attributes = {"POSITION": 0, **({f"TEXCOORD_{info.get('texCoord', 0)}": 2} if has_uv else {})}
    further = [glow] if glow else []
    return gltf(folder, materials=[material], textures=[texture, *({**texture, "sampler": 1} for _ in further)],
                images=[{"uri": "picture.png"}], samplers=[sampler, *further], accessors=accessors, bufferViews=views,
                buffers=[{"byteLength": 60}, {"byteLength": 32, "uri": "uv.bin"}],
                meshes=[{"primitives": [{"attributes": attributes, "indices": 1, "material": 0}]}])


@pytest.mark.parametrize("emits", [False, True])
def test_a_face_of_gltf_has_the_colour_of_its_part(tmp_path, emits):
    scene = load_scene(picture_file(tmp_path, ATLAS, emits=emits))
    assert scene.channels("emission" if emits else "diffuse") == pytest.approx(np.array([RED]) / 255, abs=1e-9)


@pytest.mark.parametrize(("transform", "colour"), [
    ({}, RED), ({"offset": [0.5, 0]}, GREEN), ({"scale": [1, -1], "offset": [0, 1]}, BLUE),
    # The example of the extension: the lower left quarter, turned.
    ({"offset": [0, 1], "rotation": np.pi / 2, "scale": [0.5, 0.5]}, BLUE),
    ({"offset": [1, 0.75], "rotation": np.pi, "scale": [0.5, 0.5]}, WHITE),
    # Scaled before it is turned: from (1/4, 1/2) on, half as wide as it is high.
    ({"offset": [0.25, 0], "rotation": np.pi / 2, "scale": [1, 0.5]}, BLUE)])
def test_a_texture_of_gltf_is_placed_by_its_transform_and_set_of_coordinates(tmp_path, transform, colour):
    info = {"texCoord": 3, "extensions": {"KHR_texture_transform": transform}}
    scene = load_scene(picture_file(tmp_path, ATLAS, info=info))
    assert scene.channels("diffuse") == pytest.approx(np.array([colour]) / 255, abs=1e-9)


def test_a_picture_of_webp_is_read(tmp_path):
    scene = load_scene(picture_file(tmp_path, ATLAS, webp=True))
    assert scene.channels("diffuse") == pytest.approx(np.array([RED]) / 255, abs=1e-9)


def test_a_face_of_gltf_without_coordinates_has_the_mean_of_the_picture_and_a_warning(tmp_path):
    path = picture_file(tmp_path, ATLAS, has_uv=False)
    with pytest.warns(InputWarning) as caught:
        scene = load_scene(path)
    assert [str(warning.message) for warning in caught] == [
        f"{path}: not used: texture of a face without coordinates (2)"]
    assert scene.channels("diffuse") == pytest.approx(np.array([Texture(ATLAS).mean()]), abs=0.01)


def test_a_file_outside_of_the_folder_of_a_gltf_is_refused(tmp_path):
    write(tmp_path, "a.bin", b"0")
    (tmp_path / "b").mkdir()
    path = gltf(tmp_path / "b", buffers=[{"byteLength": 1, "uri": "../a.bin"}])
    assert refusal(path) == f"{path}: {tmp_path / 'b' / '..' / 'a.bin'} is not read: it is outside of the file's folder"


@pytest.mark.parametrize("kind", ["buffers", "images"])
@pytest.mark.parametrize(("uri", "reason"), [("a\0b", "embedded null byte"), ("a\ud800b", "surrogates not allowed"),
                                             ("a%00b", "embedded null byte")])
def test_a_name_that_no_file_can_have_is_refused(tmp_path, kind, uri, reason):
    path = gltf(tmp_path, **{kind: [{"byteLength": 1, "uri": uri}]})
    assert re.fullmatch(rf"{path}: '.*' cannot be read \(.*{reason}\)", refusal(path))


@pytest.mark.parametrize(("sampler", "colour"), [
    ({}, RED), ({"wrapS": 33071}, GREEN), ({"wrapT": 33071}, BLUE), ({"wrapS": 33071, "wrapT": 33071}, WHITE)])
def test_each_side_of_a_texture_of_gltf_has_its_wrap(tmp_path, sampler, colour):
    """Behind the right and the lower border."""
    scene = load_scene(picture_file(tmp_path, ATLAS, shift=(1, 1), **sampler))
    assert scene.channels("diffuse") == pytest.approx(np.array([colour]) / 255, abs=1e-9)


def test_two_textures_of_gltf_with_one_picture_have_their_own_wraps(tmp_path):
    """Behind the right border."""
    scene = load_scene(picture_file(tmp_path, ATLAS, glow={"wrapS": 33071}, shift=(1, 0)))
    for channel, colour in ("diffuse", RED), ("emission", GREEN):
        assert scene.channels(channel) == pytest.approx(np.array([colour]) / 255, abs=1e-9)


def test_a_texture_of_gltf_that_cannot_be_read_is_refused(tmp_path):
    path = picture_file(tmp_path, ATLAS)
    (tmp_path / "picture.png").write_bytes(b"no picture")
    assert refusal(path) == f"{path}: baseColorTexture 0 cannot be read as a picture of at most {MOST_PIXELS} pixels"


def test_a_large_texture_is_refused_and_not_dropped(tmp_path, monkeypatch):
    monkeypatch.setattr("golden.scene.texture.MOST_PIXELS", 255)
    path = picture_file(tmp_path, ATLAS)
    assert refusal(path) == f"{path}: a picture has 16 x 16 pixels, at most 255 are read"


def test_an_image_is_not_written_over_a_texture(tmp_path):
    path = textured(tmp_path, "f 1/1 2/2 3/3 4/4\n")
    before = (tmp_path / "atlas.png").read_bytes()
    result = run("render", path, "--sky", "1,1,1", "-o", tmp_path / "atlas.png")
    assert (result.exit_code, result.stderr) == (2, f"error: output {str(tmp_path / 'atlas.png')!r}: it is the input\n")
    assert (tmp_path / "atlas.png").read_bytes() == before
    assert load_scene(picture_file(tmp_path, ATLAS)).files == (
        tmp_path / "a.glb", tmp_path / "uv.bin", tmp_path / "picture.png")
