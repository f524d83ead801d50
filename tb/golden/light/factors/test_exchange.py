"""Enclosures with closed forms: Siegel and Howell, Thermal Radiation Heat Transfer."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

from golden.base.errors import InputError
from golden.light.factors import exchange
from golden.light.factors.exchange import STEFAN_BOLTZMANN, net_exchange, script_f
from golden.light.factors.view_factors import ViewFactors
from tb.golden.light.solvers.systems import DUCT_FACTORS
from tb.lib.schedules import SETTINGS

DUCT_AREA = np.array([3.0, 4, 5])


def enclosure(matrix, area):
    matrix = np.asarray(matrix, dtype=float)
    return ViewFactors(F=sparse.csr_array(matrix), sky=np.maximum(1 - matrix.sum(axis=1), 0).round(15),
                       back=np.zeros(len(area)), patch=np.arange(len(area)), front=np.ones(len(area), dtype=bool),
                       area=np.asarray(area, dtype=float), normal=np.zeros((len(area), 3)),
                       surface=np.array([f"side {number}" for number in range(len(area))]))


# A body of area 2 inside one of area 5.
BODY = enclosure([(0, 1), (2 / 5, 3 / 5)], (2, 5))
DUCT = enclosure(DUCT_FACTORS, DUCT_AREA)


def black(*temperatures):
    return STEFAN_BOLTZMANN * np.array(temperatures)**4


@pytest.mark.parametrize("emissivity", [(0.8, 0.3), (0.05, 0.99), (1, 1), (0.5, 1)])
def test_a_body_in_another_one(emissivity):
    found = net_exchange(BODY, temperature=(900.0, 300.0), emissivity=emissivity)
    emitted, other = black(900.0, 300.0)
    resistance = (1 - emissivity[0]) / (2 * emissivity[0]) + 1 / 2 + (1 - emissivity[1]) / (5 * emissivity[1])
    heat = (emitted - other) / resistance
    np.testing.assert_allclose(found.flux * BODY.area, (heat, -heat), rtol=1e-11)
    np.testing.assert_array_equal(found.temperature, (900, 300))
    np.testing.assert_allclose(found.radiosity - found.irradiance, found.flux, rtol=1e-9)


def test_a_duct_with_an_adiabatic_side():
    emissivity = np.array([0.8, 0.4, 0.6])
    found = net_exchange(DUCT, temperature=(1200.0, 500.0, np.nan), emissivity=emissivity, flux=(np.nan, np.nan, 0))
    conductance = DUCT_AREA[:, None] * DUCT_FACTORS
    through = 1 / (1 / conductance[0, 2] + 1 / conductance[1, 2])
    resistance = ((1 - emissivity) / (DUCT_AREA * emissivity))[:2].sum() + 1 / (conductance[0, 1] + through)
    emitted, other = black(1200.0, 500.0)
    heat = (emitted - other) / resistance
    np.testing.assert_allclose(found.flux * DUCT_AREA, (heat, -heat, 0), atol=1e-9 * heat)
    # The adiabatic side takes the radiosity that it receives, whatever its emissivity.
    assert STEFAN_BOLTZMANN * found.temperature[2]**4 == pytest.approx(found.irradiance[2], rel=1e-11)


@st.composite
def enclosures(draw):
    """Sides of unequal areas, of which every two may see each other, open or closed or both."""
    count = draw(st.integers(1, 5))
    area = np.array([draw(st.sampled_from((0.1, 1.0, 3.0, 20.0))) for _ in range(count)])
    shared = np.zeros((count, count))
    for i in range(count):
        for j in range(i + 1):
            shared[i, j] = shared[j, i] = draw(st.sampled_from((0.0, 0.5, 1.0))) if j < i - 1 else 1.0
    # The fullest row closes, unless all are open.
    shared *= draw(st.sampled_from((1.0, 0.7))) / (shared.sum(axis=1) / area).max()
    return enclosure(shared / area[:, None], area)


@settings(SETTINGS, max_examples=80)
@given(enclosures(), st.data())
def test_given_fluxes_and_temperatures_in_any_mixture_are_in_balance(factors, data):
    """Those of a dense solution with all temperatures given, of which some are replaced by the fluxes that follow."""
    count, sky = len(factors), data.draw(st.sampled_from((0.0, 250.0)))
    emissivity = np.array([data.draw(st.sampled_from((1.0, 0.3, 0.05, 0.0) if side else (1.0, 0.3)))
                           for side in range(count)])
    temperature = np.array([data.draw(st.sampled_from((100.0, 300.0, 1200.0))) for _ in range(count)])
    emitted, outside = emissivity * black(*temperature), factors.sky * STEFAN_BOLTZMANN * sky**4
    matrix = factors.F.toarray()
    radiosity = np.linalg.solve(np.eye(count) - (1 - emissivity)[:, None] * matrix,
                                emitted + (1 - emissivity) * outside)
    irradiance = matrix @ radiosity + outside
    flux = radiosity - irradiance
    has_flux = np.array([data.draw(st.booleans()) for _ in range(count)]) & (emissivity > 0)
    has_flux[0] = False
    found = net_exchange(factors, emissivity=emissivity, temperature=np.where(has_flux, np.nan, temperature),
                         flux=np.where(has_flux, flux, np.nan), sky_temperature=sky)
    scale = max(emitted.max(), outside.max(), 1e-30)
    for values, expected in ((found.radiosity, radiosity), (found.irradiance, irradiance), (found.flux, flux),
                             (black(*found.temperature), black(*temperature))):
        # A temperature follows from its flux over the emissivity, here at least 0.05.
        np.testing.assert_allclose(values, expected, rtol=0, atol=1e-8 * scale)


@pytest.mark.parametrize("emissivity", [0.5, 1e-3, 1e-5])
def test_a_body_that_heats_adiabatic_walls_gives_them_its_temperature(emissivity):
    """All parts of a sphere, however polished."""
    area = np.linspace(1, 2, 150)
    found = net_exchange(enclosure(np.tile(area / area.sum(), (150, 1)), area), flux=[np.nan] + [0.0] * 149,
                         temperature=[1500.0] + [np.nan] * 149, emissivity=np.full(150, emissivity))
    np.testing.assert_allclose(found.temperature, 1500, rtol=1e-8)


@pytest.mark.parametrize("emissivity", [1e-10, 1e-16, 1e-300])
def test_walls_that_reflect_all_but_nothing_are_refused(emissivity):
    """Their radiation is that of rounding: at 1e-13 a wall of 1500 K would be 18 K off."""
    for temperature in (900.0, np.nan):
        with pytest.raises(InputError, match="patch 0: less than 1e-09 of the radiation around it is absorbed"):
            net_exchange(BODY, temperature=(300.0, temperature), emissivity=(emissivity, emissivity),
                         flux=(np.nan, np.nan if temperature > 0 else 0.0))
    with pytest.raises(InputError, match="patch 0: less than 1e-09"):
        script_f(BODY, emissivity=(emissivity, emissivity), group=(0, 1))


def test_rooms_in_a_row_are_in_balance_beside_dark_mirrors():
    """Each sees its neighbours alone: light takes more steps than a search has."""
    row = np.diag(np.full(301, 0.5), 1) + np.diag(np.full(301, 0.5), -1)
    row[0, 0] = row[-3, -3] = row[-1, -1] = row[-2, -2] = 0.5
    row[-3, -2] = row[-2, -3] = 0  # the last two see each other and themselves
    found = net_exchange(enclosure(row, np.ones(302)), temperature=[1500.0] + [np.nan] * 299 + [300.0] * 2,
                         emissivity=[0.1] * 300 + [0.0] * 2, flux=[np.nan] + [0.0] * 299 + [np.nan] * 2)
    np.testing.assert_allclose(found.temperature[:300], 1500, rtol=1e-8)
    np.testing.assert_array_equal(found.radiosity[-2:], 0)


def test_what_the_last_elimination_leaves_counts(monkeypatch):
    """Searches that find nothing, and eliminations in float32: the second one corrects the first."""
    eliminated = exchange._eliminated

    def in_float32(*system):
        return eliminated(*system).astype(np.float32)

    monkeypatch.setattr(exchange, "_searched", lambda matrix, reflected, own: np.zeros_like(own))
    monkeypatch.setattr(exchange, "_eliminated", in_float32)
    emissivity, emitted = np.array([0.8, 0.3]), black(900.0, 300.0)
    found = net_exchange(BODY, temperature=(900.0, 300.0), emissivity=emissivity)
    expected = np.linalg.solve(np.eye(2) - (1 - emissivity)[:, None] * BODY.F.toarray(), emissivity * emitted)
    np.testing.assert_allclose(found.radiosity, expected, rtol=1e-12)


@pytest.mark.parametrize("emissivity", [0.5, 1e-3, 1e-6])
def test_polished_walls_of_a_sphere(emissivity):
    """All parts of a sphere receive the same, in balance the mean of what black ones would emit."""
    area, temperature = np.linspace(1, 2, 96), np.linspace(300, 900, 96)
    found = net_exchange(enclosure(np.tile(area / area.sum(), (96, 1)), area), temperature=temperature,
                         emissivity=np.full(96, emissivity))
    mean = area @ black(*temperature) / area.sum()
    np.testing.assert_allclose(found.flux, emissivity * (black(*temperature) - mean), rtol=0,
                               atol=1e-13 * mean)


def test_what_takes_in_all_that_arrives_is_at_zero_kelvin_whatever_brings_it():
    factors, emissivity = enclosure(0.2 * (1 - np.eye(4)), np.ones(4)), np.full(4, 0.3)
    for temperature, sky in ((np.zeros(4), 250.0), (np.array([0.0, 0, 0, 300]), 0.0)):
        flux = net_exchange(factors, temperature=temperature, emissivity=emissivity, sky_temperature=sky).flux[0]
        others = {"temperature": [np.nan, *temperature[1:]], "emissivity": emissivity, "sky_temperature": sky}
        found = net_exchange(factors, flux=[flux, np.nan, np.nan, np.nan], **others)
        # Rounding by 2^-52 of what arrives is a temperature of less than 1e-3 of the source's.
        assert found.temperature[0] < 1e-3 * max(temperature.max(), sky)
        with pytest.raises(InputError, match="cannot take in more than arrives"):
            net_exchange(factors, flux=[1.001 * flux, np.nan, np.nan, np.nan], **others)


def test_equal_temperatures_exchange_nothing():
    found = net_exchange(DUCT, temperature=np.full(3, 400.0), emissivity=(0.1, 0.5, 0.9))
    np.testing.assert_allclose(found.radiosity, black(400.0)[0], rtol=1e-12)
    np.testing.assert_allclose(found.flux, 0, atol=1e-9)


def test_black_backs_radiate_as_the_sky_does():
    given = {"temperature": (900.0, 300.0), "emissivity": (0.8, 0.3), "sky_temperature": 400.0}
    open_side = enclosure([(0, 0.5), (0.2, 0.6)], (2, 5))
    behind = replace(open_side, sky=open_side.sky / 4, back=open_side.sky * 3 / 4)
    for name, values in vars(net_exchange(open_side, **given)).items():
        np.testing.assert_allclose(getattr(net_exchange(behind, **given), name), values, rtol=1e-12)


def test_a_plate_under_the_sky():
    plate = enclosure([[0]], [1])
    found = net_exchange(plate, temperature=[300.0], emissivity=[0.9], sky_temperature=250.0)
    assert found.flux[0] == pytest.approx(0.9 * (black(300.0) - black(250.0))[0])
    found = net_exchange(plate, temperature=[np.nan], emissivity=[0.9], flux=[0.0], sky_temperature=250.0)
    assert found.temperature[0] == pytest.approx(250)


@pytest.mark.parametrize("emissivity", [(0.8, 0.4, 0.6), (1e-3, 1e-4, 2e-3)])
def test_script_f_of_three_sides(emissivity):
    emissivity = np.array(emissivity)
    shares = script_f(DUCT, emissivity=emissivity, group=np.arange(3))
    # By elimination: e F (1 - (1 - e) F)^-1 e.
    matrix = np.diag(emissivity) @ DUCT_FACTORS @ np.linalg.inv(
        np.eye(3) - (1 - emissivity)[:, None] * DUCT_FACTORS) @ np.diag(emissivity)
    np.testing.assert_allclose(shares, matrix, rtol=1e-11)
    np.testing.assert_allclose(shares.sum(axis=1), emissivity, rtol=1e-11)
    np.testing.assert_allclose(DUCT_AREA[:, None] * shares, (DUCT_AREA[:, None] * shares).T, rtol=1e-11)
    temperature = (1200.0, 500.0, 700.0)
    emitted = black(*temperature)
    found = net_exchange(DUCT, temperature=temperature, emissivity=emissivity)
    np.testing.assert_allclose((shares * (emitted[:, None] - emitted)).sum(axis=1), found.flux, rtol=1e-10)


def test_script_f_of_groups_is_that_of_their_patches():
    emissivity = np.array([0.8, 0.4, 0.4])
    single = script_f(DUCT, emissivity=emissivity, group=np.arange(3)) * DUCT_AREA[:, None]
    pairs = script_f(DUCT, emissivity=emissivity, group=[0, 1, 1])
    np.testing.assert_allclose(pairs[0], (single[0, 0] / 3, single[0, 1:].sum() / 3), rtol=1e-11)
    np.testing.assert_allclose(pairs[1, 1], single[1:, 1:].sum() / 9, rtol=1e-11)


@pytest.mark.parametrize(("given", "message"), [
    ({"temperature": (300.0, 300.0)}, "one value for each of 3 patches"),
    ({"temperature": (300.0, np.nan, 300.0)}, "patch 1: it must have either a temperature or a flux"),
    ({"temperature": (300.0, 1, 2), "flux": (np.nan, 1, np.nan)}, "patch 1: it must have either"),
    ({"temperature": (300.0, -1, 300.0)}, "at least 0 K"), ({"temperature": (300.0, np.inf, 300.0)}, "finite"),
    ({"emissivity": (0.5, 1.1, 0.5)}, "patch 1: Emissivity must be 0 to 1, not 1.1"),
    ({"emissivity": (0.5, np.nan, 0.5)}, "Emissivity must be 0 to 1"),
    ({"temperature": (300.0, np.nan, 300.0), "flux": (np.nan, np.inf, np.nan)}, "Flux must be finite"),
    ({"temperature": (300.0, np.nan, 300.0), "flux": (np.nan, 0, np.nan), "emissivity": (1, 0, 1)}, "above 0"),
    ({"sky_temperature": -1.0}, "Sky temperature"),
    ({"temperature": np.full(3, np.nan), "flux": np.zeros(3)}, "patch 0: nothing sets its temperature"),
    ({"temperature": (300.0, np.nan, 300.0), "flux": (np.nan, -1e6, np.nan)}, "patch 1: it cannot take in more .* -1e"),
    ({"sky_temperature": 1e200}, "Sky temperature must be at most")])
def test_values_out_of_range_are_refused(given, message):
    with pytest.raises(InputError, match=message):
        net_exchange(DUCT, **{"temperature": (300.0, 400.0, 500.0), "emissivity": (0.5, 0.5, 0.5)} | given)


def test_each_closed_part_needs_a_temperature():
    """Two bodies in two enclosures: the other one's temperature says nothing."""
    matrix = np.zeros((4, 4))
    matrix[:2, :2] = matrix[2:, 2:] = BODY.F.toarray()
    given = {"emissivity": np.full(4, 0.5), "flux": (np.nan, np.nan, 0, 0)}
    both = enclosure(matrix, (2, 5, 2, 5))
    with pytest.raises(InputError, match="patch 2: nothing sets its temperature"):
        net_exchange(both, temperature=(300.0, 300, np.nan, np.nan), **given)
    # A body that reflects all sets no temperature either.
    with pytest.raises(InputError, match="patch 3: nothing sets its temperature"):
        net_exchange(both, temperature=(300.0, 300, 300, np.nan), emissivity=(0.5, 0.5, 0, 0.5),
                     flux=(np.nan, np.nan, np.nan, 0))
    found = net_exchange(both, temperature=(300.0, 300, 400, np.nan), emissivity=np.full(4, 0.5),
                         flux=(np.nan, np.nan, np.nan, 0))
    assert found.temperature[3] == pytest.approx(400)
