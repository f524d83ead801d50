"""All coefficients of Perez's model, beside the tables that Radiance's gendaylit and gendaymtx have of the papers.

perez.csv has table 1 of Perez, Seals, Michalsky (1993) in columns a1 to e4, and table 4 of Perez et al. (1990) in
columns diffuse_a to direct_d.
"""

import csv
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from golden.scene.sky.distributions import perez
from golden.scene.sky.weather import Weather, clearness_class

with (Path(__file__).parent / "perez.csv").open(newline="") as _file:
    TABLE = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(_file)]
# A clearness of each class.
CLEARNESS = (1.03, 1.1, 1.3, 1.7, 2.2, 3.5, 5.0, 8.0)


@pytest.mark.parametrize("number", range(8))
def test_the_sky_has_the_coefficients_of_its_class(number):
    """At the zenith, off the sun, and near the horizon."""
    row = TABLE[number]
    for zenith, brightness in product((0.0, 0.4, 1.3), (0.2, 0.35)):
        a, b, c, d, e = (np.array([row[f"{name}{k}"] for k in (1, 2, 3, 4)]) @ (
            1, zenith, brightness, brightness * zenith) for name in "abcde")
        if number == 0:
            c = np.exp((brightness * (row["c1"] + row["c2"] * zenith)) ** row["c3"]) - row["c4"]
            d = -np.exp(brightness * (row["d1"] + row["d2"] * zenith)) + row["d3"] + brightness * row["d4"]
        sine, angle = np.array([1.0, 0.5, 0.1, 0.7]), np.array([0.2, 1.0, 1.5, 2.5])
        expected = (1 + a * np.exp(b / sine)) * (1 + c * np.exp(d * angle) + e * np.cos(angle) ** 2)
        np.testing.assert_allclose(perez(CLEARNESS[number], brightness, zenith)(sine, angle), np.maximum(expected, 0),
                                   rtol=1e-12)


@pytest.mark.parametrize("number", range(8))
@pytest.mark.parametrize("zenith", [0.3, 1.2])
def test_the_efficacies_are_those_of_their_class(number, zenith):
    """Equations 7 and 8 of the paper of 1990, with 2 cm of water."""
    bent, diffuse = 1.041 * zenith**3, 100.0
    direct = diffuse * ((CLEARNESS[number] * (1 + bent) - bent) - 1)
    weather = Weather(direct=direct, diffuse=diffuse, zenith=zenith)
    assert clearness_class(weather.clearness) == number
    row, brightness = TABLE[number], weather.brightness
    a, b, c, d = (row[f"diffuse_{name}"] for name in "abcd")
    expected = diffuse * (a + b * 2 + c * np.cos(zenith) + d * np.log(brightness))
    a, b, c, d = (row[f"direct_{name}"] for name in "abcd")
    sun = max(direct * (a + b * 2 + c * np.exp(5.73 * zenith - 5) + d * brightness), 0)
    assert weather.illuminances == pytest.approx((expected, sun), rel=1e-12)
