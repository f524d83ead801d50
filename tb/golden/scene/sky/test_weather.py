import numpy as np
import pytest

from golden.base.errors import InputError
from golden.scene.sky.weather import Weather, clearness_class


def test_indices_are_those_of_the_equations():
    """By hand: epsilon = (4 + 1.041 z^3) / (1 + 1.041 z^3), Delta = 100 m / 1367, Kasten's air mass at 60 degrees."""
    weather = Weather(direct=300.0, diffuse=100.0, zenith=np.pi / 3)
    bent = 1.041 * (np.pi / 3) ** 3
    assert weather.clearness == pytest.approx((4 + bent) / (1 + bent))
    assert weather.brightness == pytest.approx(100 * 1.9927 / 1367, rel=1e-3)


@pytest.mark.parametrize(("clearness", "number"), [
    (1.0, 0), (1.064, 0), (1.065, 1), (1.23, 2), (1.5, 3), (1.95, 4), (2.8, 5), (4.5, 6), (6.2, 7), (40, 7)])
def test_classes_have_the_papers_bounds(clearness, number):
    assert clearness_class(clearness) == number


@pytest.mark.parametrize(("direct", "diffuse"), [(-1.0, 100.0), (100.0, 0.0), (2000.0, 100.0), (np.nan, 1.0)])
def test_impossible_irradiances_are_refused(direct, diffuse):
    with pytest.raises(InputError, match="Weather must be"):
        Weather(direct=direct, diffuse=diffuse, zenith=1.0).check()
