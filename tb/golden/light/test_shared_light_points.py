"""Direct light by shadow frusta, whose rays share points of lights."""

import numpy as np
import pytest

from benchmarks.analytic import point_to_polygon
from golden.cast.naive import Naive
from golden.engine.cast.fixed_frusta import NaiveFixedFrusta, ShellingFrusta
from golden.engine.cast.shadow_frusta import LEAST
from golden.light.direct import DirectLight
from golden.light.sampling import mix
from golden.light.surface_points import SurfacePoints
from golden.light.tally import Tally
from golden.scene.lights import DirectionalLight, PointLight
from golden.scene.material import Material
from tb.golden.light.scenes import BLACK, rectangle, scene_of

# Of a square light above a floor, which a square in half its height hides in part.
FLOOR = rectangle((-1, -1, 0), (2, 0, 0), (0, 2, 0))
LAMP = Material(name="lamp", emission=(1.0, 1.0, 1.0))
LIGHT = rectangle((-0.5, -0.5, 2), (0, 1, 0), (1, 0, 0))
SIDE, HEIGHT = 0.5, 1.0
GLASS = Material(name="glass", transparent=(0.9, 0.5, 0.8), refraction_index=1.0)


def blocker(height=HEIGHT):
    return rectangle((-SIDE / 2, -SIDE / 2, height), (SIDE, 0, 0), (0, SIDE, 0))


def floor_points(side, most=0.9):
    x, y = (axis.ravel() for axis in np.meshgrid(*[np.linspace(-most, most, side)] * 2))
    position = np.stack([x, y, np.zeros(len(x))], axis=1)
    return SurfacePoints(position, np.tile([0.0, 0.0, 1.0], (len(x), 1)), np.zeros(len(x), dtype=int))


def direct(scene, points, samples, caster=ShellingFrusta, *, seed=1):
    """Irradiance, and the counts of rays."""
    tally = Tally()
    light = DirectLight(scene, Naive(scene), tally, samples, frusta=caster and caster(scene))
    return light.irradiance(points, mix(seed, np.arange(len(points)))), tally.kinds


def seen_of_light(points):
    """Closed form at points of the floor: the light less its part behind the blocker, both over pi."""
    position = points.position
    whole = point_to_polygon(position, points.normal, [LIGHT])[:, 0]
    seen = whole.copy()
    for number, (x, y, _) in enumerate(position):
        # The blocker's shadow in the plane of the light is twice as large, and axis-parallel.
        low = np.maximum(2 * np.array([-SIDE / 2, -SIDE / 2]) - (x, y), -0.5)
        high = np.minimum(2 * np.array([SIDE / 2, SIDE / 2]) - (x, y), 0.5)
        if (low < high).all():
            hidden = rectangle((*low, 2), (0, high[1] - low[1], 0), (high[0] - low[0], 0, 0))
            seen[number] -= point_to_polygon(position[[number]], points.normal[[number]], [hidden])[0, 0]
    return seen, whole


def error(side, samples, caster):
    scene, points = scene_of((FLOOR, BLACK), (LIGHT, LAMP), (blocker(), BLACK)), floor_points(side)
    value, kinds = direct(scene, points, samples, caster)
    seen, whole = seen_of_light(points)
    assert 0.1 < (seen < 0.99 * whole).mean() < 1
    assert kinds["shadow"]["rays"] > 0.5 * side**2 * samples
    return np.sqrt(np.mean(((value[:, 0] - seen) / whole) ** 2))


def test_a_square_light_behind_a_square_has_its_closed_form():
    """An edge is in one of 64 strips, each with a point; an error of half a strip has the RMS 1 / (64 sqrt(3))."""
    assert error(16, 64, ShellingFrusta) < 1 / 64


@pytest.mark.nightly
@pytest.mark.parametrize(("samples", "bound", "caster"), [(4096, 3e-3, ShellingFrusta),
                                                          (65536, 1e-3, NaiveFixedFrusta)])
def test_a_square_light_behind_a_square_has_its_closed_form_closely(samples, bound, caster):
    assert error(8, samples, caster) < bound


def test_points_of_lights_serve_frusta_and_single_rays_alike():
    """Point lights are shared points, the sun is none; few points are cast singly, with the same light."""
    lights = (DirectionalLight(direction=(0.1, 0, -1), irradiance=(1, 1, 1)),
              PointLight(position=(0.2, 0.1, 1.9), intensity=(1, 2, 3)),
              PointLight(position=(-0.3, 0.2, 1.9), intensity=(3, 2, 1)))
    scene = scene_of((FLOOR, BLACK), (blocker(), BLACK), lights=lights)
    points = floor_points(20)
    value, kinds = direct(scene, points, 1)
    expected, _ = direct(scene, points, 1, None)
    np.testing.assert_array_equal(value, expected)
    assert (kinds["shadow"]["rays"], kinds["single shadow"]["rays"]) == (2 * 400, 400)
    few, kinds = direct(scene, points[:LEAST - 1], 1)
    np.testing.assert_array_equal(few, expected[:LEAST - 1])
    assert (kinds["shadow"]["rays"], kinds["single shadow"]["rays"]) == (0, 3 * (LEAST - 1))


def test_what_glass_may_let_through_is_cast_again():
    """Frusta know opaque patches alone: free rays are done, the others meet the sheets one by one."""
    lamp = (PointLight(position=(0, 0, 2), intensity=(1, 1, 1)),)
    points = floor_points(20)
    scene = scene_of((FLOOR, BLACK), (blocker(), GLASS), lights=lamp)
    value, kinds = direct(scene, points, 1)
    np.testing.assert_allclose(value, direct(scene, points, 1, None)[0], rtol=1e-12)
    behind = kinds["shadow"]["hits"]
    assert 20 < behind < 200
    # The ray, and what goes on behind its sheet.
    assert kinds["single shadow"]["rays"] == 2 * behind


def test_near_a_light_rays_are_single():
    """There a light is sampled by solid angle, at points of its own."""
    near = rectangle((-0.5, -0.5, 0.2), (0, 1, 0), (1, 0, 0))
    _, kinds = direct(scene_of((FLOOR, BLACK), (near, LAMP)), floor_points(12, most=0.3), 16)
    assert kinds["shadow"]["rays"] == 0 < kinds["single shadow"]["rays"]
