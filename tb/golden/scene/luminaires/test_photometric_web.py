import numpy as np
import pytest
from hypothesis import given, settings

from golden.base.errors import InputError
from golden.scene.luminaires.photometric_web import PhotometricWeb
from tb.golden.scene.luminaires.webs import intensity, web_tables
from tb.lib.schedules import SETTINGS

DOWN = np.array([(1.0, 0, 0), (0, 1, 0), (0, 0, -1)])


def web(gamma=(0, 90), planes=(0,), candela=((100, 100),), axes=DOWN):
    return PhotometricWeb(gamma=gamma, planes=planes, candela=candela, axes=axes)


def toward(gamma, plane=0.0):
    """A vector to the light from a point that it sees at these angles."""
    gamma, plane = np.radians(gamma), np.radians(plane)
    return -3 * np.array([(np.sin(gamma) * np.cos(plane), np.sin(gamma) * np.sin(plane), -np.cos(gamma))])


def ahead(gamma, plane):
    """`toward`, exact in both angles where they are multiples of 90 degrees."""
    return np.where(np.abs(toward(gamma, plane)) < 1e-12, 0.0, toward(gamma, plane))


@settings(SETTINGS, max_examples=60)
@given(table=web_tables())
def test_at_every_given_angle_and_between_them_the_light_is_the_tables(table):
    """At both ends of the table too; a hundredth of a degree beyond them there is none."""
    light, (low, high) = web(**table), (table["gamma"][0], table["gamma"][-1])
    angles = [*table["gamma"], *(np.add(table["gamma"][1:], table["gamma"][:-1]) / 2), low + 0.01, high - 0.01]
    angles += [angle for angle in (low - 0.01, high + 0.01) if 0 <= angle <= 180]
    planes = sorted({0.0, 90, 180, 270, *(plane % 360 for plane in table["planes"]), 359.99})
    points = [(gamma, plane) for gamma in angles for plane in planes]
    found = light.factor(np.concatenate([ahead(*point) for point in points]))
    expected = [intensity(table, *point) for point in points]
    np.testing.assert_allclose(found, expected, atol=1e-7)


def test_intensities_between_given_angles_are_linear():
    light = web(gamma=(0, 40, 90), planes=(0, 90, 360), candela=[(100, 60, 0), (100, 20, 0), (100, 60, 0)])
    for gamma, plane, value in ((0, 0, 100), (20, 0, 80), (40, 90, 20), (40, 45, 40), (65, 0, 30), (40, 225, 40)):
        assert light.factor(toward(gamma, plane)) == pytest.approx(value), (gamma, plane)


def test_axes_turn_the_light():
    light = web(gamma=(0, 45), candela=((100, 0),), axes=[(0, 1, 0), (0, 0, 1), (1, 0, 0)])
    assert light.factor(np.array([(-2.0, 0, 0), (0, 0, 2)])) == pytest.approx([100, 0])


@pytest.mark.parametrize(("gamma", "candela", "lumens"), [
    ((0, 180), ((100, 100),), 400 * np.pi), ((0, 30, 90), ((100, 100, 100),), 200 * np.pi),
    # I = 90 - gamma in degrees: 2 pi (180/pi) of the integral of (pi/2 - x) sin x, which is pi/2 - 1.
    ((0, 90), ((90, 0),), 360 * (np.pi / 2 - 1))])
def test_lumens_of_closed_forms(gamma, candela, lumens):
    assert web(gamma=gamma, candela=candela).lumens == pytest.approx(lumens)


def test_lumens_are_the_integral_of_the_intensity():
    light = web(gamma=(10, 50, 120), planes=(0, 100, 360), candela=[(100, 60, 10), (50, 20, 0), (100, 60, 10)])
    gamma, plane = (np.radians(low + (np.arange(count) + 0.5) / count * (high - low)) for low, high, count in (
        (10, 120, 550), (0, 360, 720)))
    gamma, plane = (grid.ravel() for grid in np.meshgrid(gamma, plane))
    vectors = np.stack([np.sin(gamma) * np.cos(plane), np.sin(gamma) * np.sin(plane), -np.cos(gamma)], axis=1)
    total = (light.factor(-vectors) * np.sin(gamma)).mean() * np.radians(110) * 2 * np.pi
    assert light.lumens == pytest.approx(total, rel=1e-4)


@pytest.mark.parametrize(("given", "message"), [
    ({"gamma": (0, 0)}, "Vertical angles must ascend"), ({"gamma": (0, 190)}, "Vertical angles must ascend"),
    ({"gamma": (0, np.nan)}, "Vertical angles must ascend"), ({"gamma": (0,), "candela": ((1,),)}, "at least two"),
    ({"planes": (0, 180), "candela": ((1, 1),) * 2}, "Horizontal angles must be 0 alone"),
    ({"candela": ((1, 1, 1),)}, "Intensities must be 1 x 2"),
    ({"candela": ((1, -1),)}, "Intensities must be at least 0"),
    ({"candela": ((1, 1e300),)}, "Intensities must be at least 0 and at most 1e.30")])
def test_bad_webs_are_refused(given, message):
    with pytest.raises(InputError, match=message):
        web(**given)
