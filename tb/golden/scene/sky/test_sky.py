import numpy as np
import pytest

from golden.cast.hemisphere import Hemisphere
from golden.scene.sky.distributions import cie_clear, cie_overcast, perez
from golden.scene.sky.sky import Sky

SKY = Sky(distribution=cie_overcast(), diffuse=7 * np.pi / 9, ground=0.125, up=np.array((0.0, 0, 1)),
          sun=np.array((0.0, 0, 1)))


def test_a_sky_above_the_horizon_and_a_ground_below_it():
    """The zenith has the radiance 1 by the choice of the irradiance; directions may have any length."""
    found = SKY.radiance(np.array([(0.0, 0, 9), (2, 0, 1e-9), (0, 3, 0), (0, 1, -1e-9), (0, 0, -3)]))
    np.testing.assert_allclose(found, np.repeat([[1], [1 / 3], *[[0.125]] * 3], 3, axis=1), rtol=1e-8)


@pytest.mark.parametrize("elevation", [90, 30, 0])
@pytest.mark.parametrize("distribution", [cie_clear(), perez(1, 0.2, 0.0), perez(1.065, 0.2, 1.0), perez(9, 0.3, 1.5)])
def test_towards_the_sun_and_away_from_it_a_sky_is_finite_up_to_the_horizon(distribution, elevation):
    """The sun in the zenith and on the horizon too; and the irradiance is the given one."""
    up, toward = np.eye(3)[2], np.array((np.cos(np.radians(elevation)), 0, np.sin(np.radians(elevation))))
    sky = Sky(distribution=distribution, diffuse=2.0, ground=0.0, up=up, sun=toward)
    near = toward + 1e-12 * up
    found = sky.radiance(np.array([near, (-near[0], 0, near[2]), (0, 1, 1e-12), up]))
    assert np.isfinite(found).all()
    assert found.min() >= 0
    hemisphere = Hemisphere(512, 256)
    total = np.pi * hemisphere.weights @ sky.radiance(hemisphere.directions)[:, 1] / 2**hemisphere.weight_bits
    assert total == pytest.approx(2, rel=5e-3)


def test_the_angle_from_the_sun_counts():
    toward = np.array((0.6, 0, 0.8))
    seen = []

    def distribution(sine, angle):
        seen.append(angle)
        return np.ones_like(sine)

    sky = Sky(distribution=distribution, diffuse=1.0, ground=0.0, up=np.array((0.0, 0, 1)), sun=toward)
    sky.radiance(np.array([toward, -toward, (0.8, 0, -0.6)]))
    np.testing.assert_allclose(seen[-1], (0, np.pi, np.pi / 2), atol=1e-7)
