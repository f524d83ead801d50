import numpy as np
import pytest

from golden.scene.sky.distributions import cie_clear, cie_overcast, horizontal, perez, uniform


def at(distribution, elevation, angle=1.0):
    return float(distribution(np.sin(np.radians([elevation])), np.array([angle]))[0])


def test_an_overcast_zenith_is_three_times_as_bright_as_the_horizon():
    assert at(cie_overcast(), 90) == pytest.approx(3 * at(cie_overcast(), 0))
    assert at(cie_overcast(), 30) == pytest.approx(2 / 3)


@pytest.mark.parametrize(("distribution", "truth"), [(uniform(), np.pi), (cie_overcast(), 7 * np.pi / 9)])
@pytest.mark.parametrize("zenith", [0.0, 1.2])
def test_horizontal_irradiance_has_its_closed_form(distribution, truth, zenith):
    assert horizontal(distribution, zenith) == pytest.approx(truth, rel=1e-9)


def test_horizontal_irradiance_counts_light_around_the_sun_by_its_height():
    """A lobe cos^100 around the sun, all above the horizon, has 2 pi / 102 times the sine of its elevation."""

    def lobe(sine, angle):
        return np.maximum(np.cos(angle), 0) ** 100

    for zenith in (0.0, 0.5, 1.0):
        assert horizontal(lobe, zenith) == pytest.approx(2 * np.pi / 102 * np.cos(zenith), rel=1e-4)


def test_the_clear_sky_is_that_of_the_standard():
    """CIE S 011, type 12, at 60 degrees of zenith distance, sun at 30: by hand from its equations."""
    gradation = (1 - np.exp(-0.32 / 0.5)) / (1 - np.exp(-0.32))
    angle = np.radians(30)
    near = 1 + 10 * (np.exp(-3 * angle) - np.exp(-1.5 * np.pi)) + 0.45 * np.cos(angle) ** 2
    assert at(cie_clear(), 30, angle) / at(cie_clear(), 90, angle) == pytest.approx(gradation)
    assert at(cie_clear(), 90, 0.0) / at(cie_clear(), 90, angle) == pytest.approx(
        (1 + 10 * (1 - np.exp(-1.5 * np.pi)) + 0.45) / near)


def test_no_sky_is_darker_than_black():
    sine, angle = np.meshgrid(np.linspace(0, 1, 30), np.linspace(0, np.pi, 30))
    for clearness in (1.0, 1.1, 1.3, 1.6, 2.0, 3.0, 5.0, 9.0):
        for brightness in (0.0, 0.2, 0.9):
            for zenith in (0.0, 0.7, 1.5):
                assert (perez(clearness, brightness, zenith)(sine, angle) >= 0).all()
    assert np.isfinite(cie_clear()(sine, angle)).all()


@pytest.mark.parametrize(("clearness", "least"), [
    # On both sides of each border of the classes 1.065 to 2.8, in which a thin sky counts as brighter.
    (1.0, 0.01), (1.064, 0.01), (1.066, 0.2), (1.23, 0.2), (1.5, 0.2), (1.94, 0.2), (1.96, 0.2), (2.79, 0.2),
    (2.81, 0.01), (4.5, 0.01), (6.2, 0.01), (9.0, 0.01)])
def test_the_brightness_of_the_all_weather_sky_has_limits(clearness, least):
    """Those of Radiance's gendaylit."""
    sine, angle = np.array([1.0, 0.4, 0.1]), np.array([0.3, 1.2, 2.2])

    def sky(brightness):
        return perez(clearness, brightness, 0.8)(sine, angle).tolist()

    assert sky(least / 2) == sky(least) != sky(1.01 * least)
    assert sky(0.99 * 0.6) != sky(0.6) == sky(0.7)
