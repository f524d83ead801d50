import numpy as np
import pytest

from golden.base.errors import InputError
from golden.light.tone import CURVES, automatic_exposure, luminance, tone_map


def grey(*values):
    return np.array(values, dtype=np.float64)[None, :, None].repeat(3, axis=2)


def test_luminance_of_white_is_one_and_green_weighs_most():
    assert luminance(np.ones(3)) == pytest.approx(1)
    red, green, blue = luminance(np.eye(3))
    assert green > red > blue > 0


def test_automatic_exposure_brings_the_log_average_to_middle_grey():
    image = grey(1e-3, 1.0, 1e3)
    assert automatic_exposure(image) == pytest.approx(0.18 / 0.82)
    assert automatic_exposure(100 * image) == pytest.approx(0.0018 / 0.82)


def test_automatic_exposure_ignores_black_and_survives_a_black_image():
    assert automatic_exposure(grey(0, 2.0, 0)) == pytest.approx(0.09 / 0.82)
    assert automatic_exposure(grey(0, 0)) == 1


def test_automatic_exposure_makes_the_picture_independent_of_the_unit_of_radiance():
    image = np.random.default_rng(1).random((8, 9, 3))
    np.testing.assert_array_equal(tone_map(image), tone_map(1024 * image))


@pytest.mark.parametrize("curve", CURVES)
@pytest.mark.parametrize("gamma", [None, 2.2])
def test_tone_map_is_monotonic_from_black_to_white(curve, gamma):
    shown = tone_map(grey(*np.linspace(0, 5, 400)), exposure=1.0, curve=curve, gamma=gamma)
    assert shown.dtype == np.uint8
    assert shown.shape == (1, 400, 3)
    assert (np.diff(shown[0, :, 0].astype(int)) >= 0).all()
    assert shown[0, 0].tolist() == [0, 0, 0]
    assert shown[0, -1].tolist() == [255, 255, 255]


def test_linear_curve_with_srgb_meets_the_standard_values():
    # IEC 61966-2-1: 0.21586 linear is 128/255 encoded; the straight part ends at 0.0031308.
    shown = tone_map(grey(0.21586, 0.0031308, 1.0, 7.0), exposure=1.0, curve="linear")[0, :, 0]
    assert shown.tolist() == [128, 10, 255, 255]


def test_gamma_is_the_power_law():
    assert tone_map(grey(0.25), exposure=1.0, curve="linear", gamma=2.0)[0, 0, 0] == 128
    deep = tone_map(grey(0.25, 0.0625), exposure=1.0, curve="linear", gamma=2.0, bits=16)
    assert (deep.dtype, deep[0, :, 0].tolist()) == (np.uint16, [32768, 16384])


@pytest.mark.parametrize("brightest", [0.5, 1.0, 2.0, 40.0])
def test_reinhards_white_is_what_a_hundredth_of_the_pixels_exceed_but_at_least_1(brightest):
    """Of 201 pixels the two brightest exceed it: the third one becomes white, if it is above 1."""
    values = np.concatenate([np.linspace(0, brightest, 199), [3 * brightest, 9 * brightest]])
    white = max(1, brightest)
    expected = np.clip(values * (1 + values / white**2) / (1 + values), 0, 1)
    shown = tone_map(grey(*values), exposure=1.0, gamma=1.0)[0, :, 0]
    assert shown.tolist() == np.rint(255 * expected).tolist()
    assert (shown[198] == 255) == (brightest >= 1)


def test_reinhard_halves_unit_luminance_below_a_far_white_and_keeps_hue():
    image = np.array([[[2.0, 0.8, 0.2], [1e8, 1e8, 1e8]]])
    image[0, 0] /= luminance(image[0, 0])
    shown = tone_map(image, exposure=1.0, gamma=1.0)
    np.testing.assert_allclose(shown[0, 0] / 255, np.minimum(image[0, 0] / 2, 1), atol=1 / 500)


@pytest.mark.parametrize("bad", [
    {"exposure": 0.0}, {"exposure": -1.0}, {"exposure": np.nan}, {"exposure": np.inf}, {"gamma": 0.0},
    {"gamma": np.nan}, {"gamma": 9.9e-5}, {"gamma": 1.1e4}, {"curve": "filmic"},
])
def test_bad_settings_are_named(bad):
    with pytest.raises(InputError, match=next(iter(bad)).capitalize()):
        tone_map(grey(1.0), **bad)
