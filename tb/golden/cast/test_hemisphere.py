import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.hemisphere import Hemisphere

POWERS = tuple(2**k for k in range(2, 13))


@pytest.mark.parametrize("polars", POWERS)
def test_weights_sum_to_one_exactly_and_are_within_one_unit_of_the_cell(polars):
    low, high = (np.arange(polars) + border for border in (0, 1))
    # sin^2 b - sin^2 a = sin(b + a) sin(b - a) does not cancel as the cumulative sums do.
    cell = np.sin((high + low) * np.pi / 2 / polars) * np.sin(np.pi / 2 / polars)
    for azimuths in POWERS:
        hemisphere = Hemisphere(azimuths, polars)
        weights = hemisphere.polar_weights
        assert weights.dtype == np.int64
        assert int(weights.sum()) * azimuths == 2**hemisphere.weight_bits
        assert np.abs(weights - cell / azimuths * 2.0**hemisphere.weight_bits).max() <= 1
        assert weights.min() > 0


def test_weights_have_40_bits_from_2048_azimuths_on():
    assert [Hemisphere(azimuths, 4).weight_bits for azimuths in (4, 1024, 2048, 4096)] == [32, 32, 40, 40]


def test_directions_are_at_the_cell_centres_in_the_stated_order():
    hemisphere = Hemisphere(8, 4)
    table = hemisphere.directions.reshape(4, 8, 3)
    polar = np.degrees(np.arccos(table[..., 2]))
    azimuth = np.degrees(np.arctan2(table[..., 1], table[..., 0])) % 360
    np.testing.assert_allclose(polar, np.array([11.25, 33.75, 56.25, 78.75])[:, None] + np.zeros(8), atol=1e-12)
    np.testing.assert_allclose(azimuth, np.zeros((4, 1)) + np.arange(22.5, 360, 45), atol=1e-12)
    assert (hemisphere.weights.reshape(4, 8) == hemisphere.polar_weights[:, None]).all()


@pytest.mark.parametrize("rays", [(3, 4), (4, 0), (2, 4), (4, 8192), (1000, 256), (-4, 4)])
def test_hemisphere_refuses_grids_the_machine_does_not_have(rays):
    with pytest.raises(InputError, match="must be a power of two from 4 to 4096, not "):
        Hemisphere(*rays)


@pytest.mark.parametrize("rays", [(4.0, 4), ("8", 4), (4, True)])
def test_a_hemisphere_of_no_whole_rays_is_a_programming_error(rays):
    with pytest.raises(TypeError, match=r"hemisphere: (Azimuths|Polars) must be an int, not "):
        Hemisphere(*rays)
