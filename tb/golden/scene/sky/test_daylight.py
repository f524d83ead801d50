from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest

from golden.base.errors import InputError, InputWarning
from golden.cast.hemisphere import Hemisphere
from golden.scene.sky.daylight import Daylight
from tb.golden.light.scenes import BLACK, rectangle, scene_of

SCENE = scene_of((rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), BLACK))
WEATHER = (500.0, 100.0)
SKIES = {"uniform": {"sun_illuminance": 0.0}, "cie-overcast": {}, "cie-clear": {}, "perez": {"weather": WEATHER}}


def horizontal(sky, up=(0, 0, 1)):
    """Irradiance of the directions of a fine hemisphere around +z, in W/m2."""
    hemisphere = Hemisphere(512, 256)
    return np.pi * hemisphere.weights @ sky.radiance(hemisphere.directions)[:, 1] / 2**hemisphere.weight_bits


@pytest.mark.parametrize("sky", SKIES)
@pytest.mark.parametrize("elevation", [10.0, 60.0])
def test_a_sky_has_the_illuminance_that_it_is_given(sky, elevation):
    lit = Daylight(sky=sky, sun=(120, elevation), sky_illuminance=5000.0, **SKIES[sky]).scene(SCENE, 100.0)
    assert horizontal(lit.background) == pytest.approx(50, rel=2e-3)


def test_defaults_follow_the_suns_elevation():
    unknown = Daylight(sky="cie-overcast").scene(SCENE, 1.0)
    assert horizontal(unknown.background) == pytest.approx(10_000, rel=1e-3)
    assert unknown.lights == ()
    overcast = Daylight(sky="cie-overcast", sun=(0, 30)).scene(SCENE, 1.0)
    assert horizontal(overcast.background) == pytest.approx(300 + 21_000 / 2, rel=1e-3)
    clear = Daylight(sky="cie-clear", sun=(0, 30)).scene(SCENE, 1.0)
    assert horizontal(clear.background) == pytest.approx(800 + 15_500 * np.sqrt(0.5), rel=2e-3)
    assert clear.lights[0].irradiance == pytest.approx([127_500 * np.exp(-0.42)] * 3)


@pytest.mark.parametrize(("up", "north", "toward"), [
    ((0, 0, 1), None, (np.sqrt(0.75), 0, 0.5)), ((0, 1, 0), None, (np.sqrt(0.75), 0.5, 0)),
    ((0, 0, 1), (1, 0, 5), (0, -np.sqrt(0.75), 0.5))])
def test_the_sun_in_the_east_is_to_the_right_of_the_north(up, north, toward):
    scene = scene_of((rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), BLACK), up=up)
    lit = Daylight(sky="cie-clear", sun=(90, 30), north=north).scene(scene, 1.0)
    np.testing.assert_allclose(lit.lights[0].direction, -np.array(toward), atol=1e-12)
    seen = lit.background.radiance(np.array([toward, np.array(toward) * (-1, -1, 1)]))[:, 0]
    assert seen[0] > seen[1] or up != (0, 0, 1)


def test_the_ground_reflects_sky_and_sun():
    lit = Daylight(sky="uniform", sun=(0, 30), sky_illuminance=100.0, sun_illuminance=200.0,
                   ground=0.5).scene(SCENE, 1.0)
    np.testing.assert_allclose(lit.background.radiance(np.array([(0.0, 0.3, -2)])), 0.5 * 200 / np.pi)


def test_a_sun_that_changes_nothing_is_named():
    with pytest.warns(InputWarning, match="the sun is not used: with sky uniform it shines only if"):
        lit = Daylight(sun=(0, 30)).scene(SCENE, 1.0)
    assert lit.lights == ()
    # A warning would be an error.
    assert len(Daylight(sun=(0, 30), sun_illuminance=1.0).scene(SCENE, 1.0).lights) == 1


@pytest.mark.parametrize("sky", ["uniform", "cie-overcast"])
@pytest.mark.parametrize(("elevation", "shines"), [(-5, False), (-1e-9, False), (0, False), (1e-6, True), (90, True)])
def test_a_sun_below_or_on_the_horizon_does_not_shine(elevation, shines, sky):
    daylight = Daylight(sky=sky, sky_illuminance=10_000.0, sun=(0, elevation), sun_illuminance=200.0)
    with nullcontext() if shines else pytest.warns(InputWarning, match="the sun is not used: it is not above the hor"):
        lit = daylight.scene(SCENE, 1.0)
    assert len(lit.lights) == shines
    # Without an illuminance nothing is lost, and a warning would be an error.
    replace(daylight, sun_illuminance=0.0).scene(SCENE, 1.0)
    level = 10_000 + 200 * max(0, np.sin(np.radians(elevation)))
    np.testing.assert_allclose(lit.background.radiance(-np.eye(3)[2:]), 0.2 * level / np.pi)


@pytest.mark.parametrize(("given", "message"), [
    ({"sky": "blue"}, "Sky must be one of"), ({"sun": (0, 91)}, "Sun must be an azimuth"),
    ({"sun": (np.nan, 0)}, "Sun must be an azimuth"), ({"sky": "cie-clear"}, "Sun must be above .*, not nowhere"),
    ({"sky": "perez", "sun": (0, -3), "weather": WEATHER}, "Sun must be above .* -3 degrees"),
    ({"sky": "perez", "sun": (0, 3)}, "Weather must be given with sky perez, not be missing"),
    ({"weather": WEATHER}, "Weather must be given with sky perez alone"), ({"ground": 1.5}, "Ground must be 0 to 1"),
    ({"sun_illuminance": 5.0}, "Sun illuminance must have a sun"), ({"sky_illuminance": -1.0}, "Sky illuminance must"),
    ({"sky": "perez", "sun": (0, 3), "weather": (1.0, 0.0)}, "Weather must be two irradiances")])
def test_bad_values_are_refused(given, message):
    with pytest.raises(InputError, match=message):
        Daylight(**given)


def test_a_north_along_the_zenith_is_refused():
    with pytest.raises(InputError, match="North must not be zero or along"):
        Daylight(north=(0, 0, 2)).scene(SCENE, 1.0)
