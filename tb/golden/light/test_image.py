import struct
import zlib
from functools import partial

import numpy as np
import OpenEXR
import pytest
from PIL import Image, ImageDraw

from golden.light.image import false_colour, write_exr, write_png
from tb.golden.light.exr import read_exr


@pytest.fixture
def radiance():
    return np.random.default_rng(7).gamma(0.5, 10.0, (6, 11, 3))


def test_png_holds_the_picture_exactly(tmp_path, radiance):
    image = radiance.astype(np.uint8)
    write_png(tmp_path / "a.png", image)
    with Image.open(tmp_path / "a.png") as stored:
        np.testing.assert_array_equal(np.asarray(stored), image)


def test_exr_holds_linear_radiance_in_float32(tmp_path, radiance):
    write_exr(tmp_path / "a.exr", radiance, white=179.0)
    np.testing.assert_array_equal(read_exr(tmp_path / "a.exr"), radiance.astype(np.float32))


def chunks(path):
    """The chunks of a PNG file by their names, whose checksums are right."""
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    place, found = 8, {}
    while place < len(data):
        length, name = struct.unpack(">I4s", data[place:place + 8])
        body = data[place + 8:place + 8 + length]
        assert zlib.crc32(name + body) == int.from_bytes(data[place + 8 + length:place + 12 + length])
        found[name] = body
        place += 12 + length
    return found


def test_png_of_16_bits_holds_the_picture_exactly(tmp_path):
    """Read by hand, row by row as differences from the one above; Pillow shows the upper bytes."""
    image = np.random.default_rng(3).integers(0, 1 << 16, (5, 7, 3)).astype(np.uint16)
    write_png(tmp_path / "a.png", image)
    found = chunks(tmp_path / "a.png")
    assert struct.unpack(">2I5B", found[b"IHDR"]) == (7, 5, 16, 2, 0, 0, 0)
    rows = np.frombuffer(zlib.decompress(found[b"IDAT"]), np.uint8).reshape(5, -1)
    assert (rows[:, 0] == 2).all()
    whole = np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8)
    np.testing.assert_array_equal(np.ascontiguousarray(whole).view(">u2").reshape(image.shape), image)
    with Image.open(tmp_path / "a.png") as stored:
        np.testing.assert_array_equal(np.asarray(stored), image >> 8)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
@pytest.mark.parametrize(("gamma", "inverse"), [(None, 45455), (2.0, 50000), (1e-4, 10**9), (1e4, 10)])
def test_png_states_its_primaries_and_its_curve(tmp_path, kind, gamma, inverse):
    """White D65 first, then red, green and blue of BT.709, in units of 1e-5; sRGB alone has a chunk of its own."""
    write_png(tmp_path / "a.png", np.zeros((2, 2, 3), dtype=kind), gamma=gamma)
    found = chunks(tmp_path / "a.png")
    assert struct.unpack(">8I", found[b"cHRM"]) == (31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000)
    assert struct.unpack(">I", found[b"gAMA"]) == (inverse,)
    assert found.get(b"sRGB") == (b"\0" if gamma is None else None)


def test_exr_states_its_primaries_and_the_luminance_of_white(tmp_path, radiance):
    write_exr(tmp_path / "a.exr", radiance, white=179.0)
    header = OpenEXR.File(str(tmp_path / "a.exr")).header()
    assert header["chromaticities"] == pytest.approx((0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329))
    assert header["whiteLuminance"] == 179


@pytest.mark.parametrize(("write", "name"), [(write_png, "a.png"), (partial(write_exr, white=1.0), "a.exr")])
def test_same_image_gives_same_bytes_and_nothing_but_the_file(tmp_path, radiance, write, name):
    image = radiance.astype(np.uint8) if write is write_png else radiance
    for folder in ("first", "second"):
        (tmp_path / folder).mkdir()
        write(tmp_path / folder / name, image)
        assert [path.name for path in (tmp_path / folder).iterdir()] == [name]
    assert (tmp_path / "first" / name).read_bytes() == (tmp_path / "second" / name).read_bytes()


def test_false_colour_grows_brighter_with_the_value():
    ramp = false_colour(np.linspace(0, 9, 300)[None, :].repeat(4, axis=0), "tests")[0].astype(int)
    assert (np.diff(ramp @ [2126, 7152, 722]) >= 0).all()
    assert ramp[0].max() < 10
    assert ramp[-1].min() > 200


def test_false_colour_has_a_legend_below_a_small_picture():
    heat = false_colour(np.ones((5, 3)), "cell steps per pixel")
    assert heat.shape[0] > 5
    assert heat.shape[1] > 200
    assert heat[5:].max() == 255, "the legend is empty"
    assert not heat[:5, 3:].any(), "beside the picture is black"


def test_false_colour_may_end_below_the_largest_value():
    """The mean and the ramp's left end stay, what is beyond has the colour of the end."""
    values = np.array([[0.0, 1, 2, 9, 90]])
    whole, cut = false_colour(values, "lux"), false_colour(values, "lux", top=2.0)
    assert (cut[0, 2:5] == cut[0, 4]).all()
    assert (cut[0, 0] == whole[0, 0]).all()
    assert (cut[0, 1] != whole[0, 1]).any()
    assert (cut[1:] != whole[1:]).any(), "the legend has the same numbers"


def test_false_colour_never_ends_above_the_largest_value():
    values = np.array([[0.0, 1, 2, 9]])
    assert (false_colour(values, "lux", top=100.0) == false_colour(values, "lux")).all()


def test_a_logarithmic_scale_has_equal_steps_for_equal_ratios():
    """Three decades below 1000: 1000, 100, 10 and 1 are at 1, 2/3, 1/3 and 0 of the ramp, and all below is black."""
    values = np.array([[1000.0, 100, 10, 1, 0.01, 0]])
    found = false_colour(values, "cd/m2", decades=3)[0, :6]
    linear = false_colour(np.array([[3.0, 2, 1, 0, 0, 0]]), "cd/m2")[0, :6]
    np.testing.assert_array_equal(found, linear)
    # With the top at 100 the middle of two decades is 10.
    cut = false_colour(values, "cd/m2", top=100.0, decades=2)[0, :6]
    np.testing.assert_array_equal(cut, false_colour(np.array([[2.0, 2, 1, 0, 0, 0]]), "cd/m2")[0, :6])


@pytest.mark.parametrize(("given", "ends"), [
    ({}, ["0", "500", "1000"]), ({"top": 100.0}, ["0", "50", ">= 100"]),
    ({"decades": 4}, ["<= 0.1", "10", "1000"]), ({"top": 100.0, "decades": 2}, ["<= 1", "10", ">= 100"])])
def test_the_legend_names_the_values_at_the_left_end_in_the_middle_and_at_the_right_end(monkeypatch, given, ends):
    texts, draw = {}, ImageDraw.ImageDraw.text
    monkeypatch.setattr(ImageDraw.ImageDraw, "text", lambda self, place, text, **more: (
        texts.update({place: text}), draw(self, place, text, **more)))
    false_colour(np.array([[1000.0, 5, 0]]), "lux", **given)
    lowest = max(y for _, y in texts)
    assert [text for (x, y), text in sorted(texts.items()) if y == lowest] == ends


def test_false_colour_of_nothing_is_black():
    assert false_colour(np.zeros((4, 4)), "tests", decades=2.0)[:4, :4].max() < 10
    assert false_colour(np.zeros((4, 4)), "tests")[:4, :4].max() < 10
