import numpy as np
import pytest

from golden.light import pixels
from golden.light.in_flight import InFlight
from golden.render.two_pass import RenderSettings, render
from golden.scene.camera import Camera
from golden.scene.material import Material
from tb.golden.light.scenes import BLACK, rectangle, scene_of

FLOOR = rectangle((-2, -2, 0), (4, 0, 0), (0, 4, 0)), Material(name="grey", diffuse=(0.5, 0.5, 0.5))
LAMP = rectangle((-0.5, -0.5, 2), (0, 1, 0), (1, 0, 0)), Material(name="lamp", emission=(4, 2, 1))
SCREEN = rectangle((0, -9, 1), (0, 18, 0), (9, 0, 0)), BLACK
"""Half of the floor is in its shadow, and light falls off from x = -0.5 to 0.5."""

ABOVE = Camera(eye=(0, 0, 0.99), target=(0, 0, 0), up=(0, 1, 0), fov=90)
"""Sees the floor from x = -1 to 1."""

NOISE = 0.04


def picture(*parts, **settings):
    chosen = {"width": 24, "height": 24, "light_samples": 8, "rays": (16, 4), "max_edge": 9.0, "method": "naive"}
    return render(scene_of(*parts), camera=ABOVE, settings=RenderSettings(**(chosen | settings)))


def error(image, truth):
    """The root of the mean square of relative errors, as `golden.light.pixels` defines them."""
    return np.sqrt((((image - truth).mean(axis=2) / (truth.mean(axis=2) + pixels.DARK * truth.mean())) ** 2).mean())


@pytest.fixture(scope="module")
def truth():
    return picture(FLOOR, LAMP, SCREEN, samples=64, light_samples=16, method="grid").image


@pytest.fixture(scope="module")
def quiet():
    return picture(FLOOR, LAMP, SCREEN, noise=NOISE)


def test_a_penumbra_has_the_requested_noise(truth, quiet):
    """Each pixel stops where nine estimates of one degree of freedom each have a mean below the request: the request
    times the root of 9 / chi2(9), which is at most 1.65 in 19 of 20 pixels.
    """
    assert error(picture(FLOOR, LAMP, SCREEN).image, truth) > 1.5 * NOISE
    assert error(quiet.image, truth) < 1.65 * NOISE
    assert quiet.stats["noise"]["above"] == 0


def test_no_ray_is_spent_where_light_is_constant(quiet):
    """Brute force tests all patches for each ray, so tests count the rays of a pixel."""
    rays = quiet.tests / 3
    assert rays.sum() == quiet.stats["rays"]["primary"]["rays"] == quiet.stats["noise"]["samples"] * rays.size
    assert (rays[:, :3] == 4).all()
    assert (rays[:, 12:17] > 4).mean() > 0.9
    alone = picture(FLOOR, LAMP, noise=NOISE)
    assert (alone.tests == 2 * 4).all()
    np.testing.assert_array_equal(alone.image, picture(FLOOR, LAMP).image)


def test_the_estimate_is_the_error(truth):
    """Of pixels nearly all of which are cast once, and not less than it.

    Of n stratified samples the variance falls by up to n^-3: halves overestimate it fourfold. That the larger of two
    estimates counts adds up to a half.
    """
    found = picture(FLOOR, LAMP, SCREEN, noise=1.0, samples=16)
    assert found.stats["noise"]["samples"] < 20
    assert 0.9 < found.stats["noise"]["estimate"] / error(found.image, truth) < np.sqrt(4 * 1.5)


def test_noise_that_remains_is_reported():
    found = picture(FLOOR, LAMP, SCREEN, noise=0.001, samples=1024, width=6, height=1)
    assert found.stats["noise"]["samples"] == 1024
    assert found.stats["noise"]["above"] > 0


def test_pixels_do_not_depend_on_blocks_and_threads(quiet, monkeypatch):
    monkeypatch.setattr(InFlight, "of", lambda *_, **__: InFlight(primary=1 << 9))
    np.testing.assert_array_equal(
        picture(FLOOR, LAMP, SCREEN, noise=NOISE, method="grid", jobs=2).image, quiet.image)


def test_rays_of_a_regular_screen_stay_the_same():
    """Light is sampled again at the same points, with the bytes of any caster in fixed point: no aliasing is cured."""
    one, other = (picture(FLOOR, LAMP, SCREEN, noise=NOISE, method=method, width=8, height=8)
                  for method in ("shelling", "naive-fixed"))
    np.testing.assert_array_equal(one.image, other.image)
    assert one.stats["noise"]["samples"] > 4
    glow = rectangle((0, -9, 0.5), (0, 18, 0), (9, 0, 0))[::-1], LAMP[1]
    edge = picture(glow, noise=NOISE, method="shelling", width=9, height=1, samples=9)
    assert set(np.unique(edge.image[..., 0])) - {0, 4}
    # The pixel of the edge and its neighbours are cast again.
    assert edge.stats["noise"] == pytest.approx({"estimate": 0, "samples": 9 * (1 + 4 * 3 / 9), "above": 0})
