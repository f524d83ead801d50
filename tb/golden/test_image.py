import numpy as np
import pytest
from PIL import Image

from golden.image import false_colour, read_exr, write_exr, write_png


@pytest.fixture
def radiance():
    return np.random.default_rng(7).gamma(0.5, 10.0, (6, 11, 3))


def test_png_holds_the_picture_exactly(tmp_path, radiance):
    image = radiance.astype(np.uint8)
    write_png(tmp_path / "a.png", image)
    with Image.open(tmp_path / "a.png") as stored:
        np.testing.assert_array_equal(np.asarray(stored), image)


def test_exr_holds_linear_radiance_in_float32(tmp_path, radiance):
    write_exr(tmp_path / "a.exr", radiance)
    np.testing.assert_array_equal(read_exr(tmp_path / "a.exr"), radiance.astype(np.float32))


@pytest.mark.parametrize(("write", "name"), [(write_png, "a.png"), (write_exr, "a.exr")])
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


def test_false_colour_of_nothing_is_black():
    assert false_colour(np.zeros((4, 4)), "tests")[:4, :4].max() < 10
