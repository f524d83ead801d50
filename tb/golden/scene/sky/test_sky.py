import numpy as np

from golden.scene.sky.distributions import cie_overcast
from golden.scene.sky.sky import Sky

SKY = Sky(distribution=cie_overcast(), diffuse=7 * np.pi / 9, ground=0.125, up=np.array((0.0, 0, 1)),
          sun=np.array((0.0, 0, 1)))


def test_a_sky_above_the_horizon_and_a_ground_below_it():
    """The zenith has the radiance 1 by the choice of the irradiance; directions may have any length."""
    found = SKY.radiance(np.array([(0.0, 0, 9), (2, 0, 0.0001), (0, 1, -0.0001), (0, 0, -3)]))
    np.testing.assert_allclose(found, np.repeat([[1], [1 / 3], [0.125], [0.125]], 3, axis=1), rtol=2e-4)


def test_the_angle_from_the_sun_counts():
    toward = np.array((0.6, 0, 0.8))
    seen = []

    def distribution(sine, angle):
        seen.append(angle)
        return np.ones_like(sine)

    sky = Sky(distribution=distribution, diffuse=1.0, ground=0.0, up=np.array((0.0, 0, 1)), sun=toward)
    sky.radiance(np.array([toward, -toward, (0.8, 0, -0.6)]))
    np.testing.assert_allclose(seen[-1], (0, np.pi, np.pi / 2), atol=1e-7)
