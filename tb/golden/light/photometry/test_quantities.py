import numpy as np
import pytest

from golden.light.photometry.quantities import EFFICACY, candela_per_m2, lux


def test_a_white_watt_has_the_efficacy_in_lumens():
    assert candela_per_m2(np.ones(3), EFFICACY) == pytest.approx(179)
    assert candela_per_m2(np.ones(3), 683.0) == pytest.approx(683)


def test_channels_have_the_weights_of_bt_709():
    np.testing.assert_allclose(candela_per_m2(np.eye(3), 1.0), (0.2126, 0.7152, 0.0722))


def test_irradiances_over_pi_become_lux():
    np.testing.assert_allclose(lux(np.full((2, 4, 3), 2.0), 100.0), np.full((2, 4), 200 * np.pi))
