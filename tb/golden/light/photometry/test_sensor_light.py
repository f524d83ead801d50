import numpy as np
import pytest

from benchmarks.analytic import point_to_polygon
from golden.light.photometry.sensors import Sensors
from golden.render.two_pass import RenderSettings, render
from golden.scene.builtin.furnace import furnace
from golden.scene.camera import Camera
from golden.scene.lights import DirectionalLight, PointLight
from golden.scene.material import Material
from tb.golden.light.scenes import BLACK, rectangle, scene_of

CAMERA = Camera(eye=(0, 0, 9), target=(0, 0, 0), up=(0, 1, 0))
COLOUR = np.array((4.0, 2.0, 1.0))
FLOOR = rectangle((-9, -9, 0), (18, 0, 0), (0, 18, 0))


def measured(scene, position, normal, **settings):
    few = {"width": 2, "height": 2, "samples": 1, "light_samples": 4, "rays": (16, 4), "max_edge": 100.0}
    return render(scene, camera=CAMERA, settings=RenderSettings(**few | settings),
                  sensors=Sensors(position=position, normal=normal)).sensors


def test_a_point_light_follows_the_square_of_the_distance_and_the_cosine():
    scene = scene_of((FLOOR, BLACK), lights=(PointLight(position=(0, 0, 2), intensity=tuple(COLOUR)),))
    found = measured(scene, [(0, 0, 0), (0, 0, 1), (0, 2, 0), (0, 0, 3)], [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)])
    shares = np.array([1 / 4, 1, np.cos(np.pi / 4) / 8, 0])
    np.testing.assert_allclose(found, shares[:, None] * COLOUR / np.pi, rtol=1e-9, atol=1e-15)


def test_a_sun_follows_the_cosine():
    scene = scene_of((FLOOR, BLACK), lights=(DirectionalLight(direction=(0, -1, -1), irradiance=tuple(COLOUR)),))
    found = measured(scene, [(0, 0, 1)] * 3, [(0, 0, 1), (0, 1, 0), (0, -1, 0)])
    np.testing.assert_allclose(found, np.array([1, 1, 0])[:, None] * COLOUR / np.sqrt(2) / np.pi, rtol=1e-9)


def test_a_sensor_on_a_surface_is_not_shaded_by_it():
    """Of a surface that is not along an axis, so that rounding leaves the sensor below or above it."""
    slope = rectangle((-9, -9, -3), (18, 0, 2), (0, 18, 4))
    scene = scene_of((slope, BLACK), background=tuple(COLOUR))
    weight = np.array([(0.3, 0.7), (0.123, 0.456), (0.9, 0.1)])
    places = slope[0] + weight @ np.array([(18, 0, 2), (0, 18, 4)])
    np.testing.assert_allclose(measured(scene, places, np.tile(scene.normals[0], (3, 1))), np.tile(COLOUR, (3, 1)))


@pytest.mark.parametrize("place", [(0.5, 0.5, 0.5), (0.2, 0.7, 0.01)])
def test_a_sensor_in_a_furnace_receives_what_its_walls_send(place):
    scene = furnace(1)
    low, high = scene.bounds
    found = measured(scene, [low + np.array(place) * (high - low)], [(0, 0, 1)], light_samples=64, max_edge=0.5)
    np.testing.assert_allclose(found, 2, rtol=0.01)


def test_a_lamp_of_many_facets_that_hide_each_other_has_its_form_factor():
    """A sensor is lit by the facets of a convex body that face it: each adds its own factor."""
    around, down = np.arange(32) / 32 * 2 * np.pi, np.arange(17) / 16 * np.pi
    ring = np.stack([np.cos(around), np.sin(around)], axis=1)
    points = np.concatenate([np.sin(down)[:, None, None] * ring, np.tile(np.cos(down)[:, None, None], (1, 32, 1))], 2)
    points = 0.5 * points + (0, 0, 2)
    points[0], points[-1] = points[0, 0], points[-1, 0]
    facets = np.stack([points[:-1], points[1:], np.roll(points, -1, axis=1)[1:], np.roll(points, -1, axis=1)[:-1]],
                      axis=2).reshape(-1, 4, 3)
    facets[-32:] = facets[-32:][:, [0, 1, 3, 3]]
    facets[:32] = facets[:32][:, [0, 1, 2, 2]]
    lamp = Material(name="lamp", emission=tuple(COLOUR))
    scene = scene_of((FLOOR, BLACK), (facets, lamp, {"two_sided": True}))
    places, up = np.array([(0, 0, 0), (1, 0, 0), (2, 2, 0)]), np.tile((0, 0, 1), (3, 1))
    truth = np.maximum(point_to_polygon(places, up, facets), 0).sum(axis=1)
    # A sphere has almost the same: its radius over the distance, squared, times the cosine.
    np.testing.assert_allclose(truth, 0.25 * 2 / (4 + (places**2).sum(axis=1)) ** 1.5, rtol=0.01)
    found = measured(scene, places, up, light_samples=2)
    np.testing.assert_allclose(found, truth[:, None] * COLOUR, rtol=0.01)


def test_a_sensor_casts_1024_times_as_many_shadow_rays_as_a_point_of_the_image():
    lamp = rectangle((-0.5, -0.5, 2), (0, 1, 0), (1, 0, 0))
    scene = scene_of((FLOOR, BLACK), (lamp, Material(name="lamp", emission=tuple(COLOUR))))
    few = RenderSettings(width=2, height=2, samples=1, light_samples=3, rays=(16, 4), max_edge=100.0)
    without, with_sensor = (
        render(scene, camera=CAMERA, settings=few, sensors=sensors).stats["rays"]["shadow"]["rays"] for sensors in
        (None, Sensors(position=np.zeros((1, 3)), normal=np.array([(0.0, 0, 1)]))))
    assert with_sensor - without == 1024 * 3
