import numpy as np
import pytest

from benchmarks.analytic import point_to_polygon
from golden.cast.grid import Grid
from golden.cast.naive import Naive
from golden.light.direct import SHEETS, DirectLight
from golden.light.in_flight import InFlight
from golden.light.sampling import mix
from golden.light.surface_points import SurfacePoints
from golden.light.tally import Tally
from golden.scene.lights import Cone, DirectionalLight, PointLight
from golden.scene.material import Material
from tb.golden.light.scenes import BLACK, rectangle, scene_of

# Light that falls on points around the origin, which belong to a patch too small to occlude any light.
RECEIVER = rectangle((-5e-7, -5e-7, 0), (1e-6, 0, 0), (0, 1e-6, 0)), BLACK
COLOUR = np.array((3.0, 2.0, 0.5))
LAMP = Material(name="lamp", emission=tuple(COLOUR))
DIM = Material(name="dim", emission=(0.5, 0.25, 1.0))

LIGHTS = {
    "overhead": rectangle((-0.5, -0.5, 1), (0, 1, 0), (1, 0, 0)),
    "wall": rectangle((1, -1, 0.2), (0, 0, 1), (0, 2, 0))[[0, 3, 2, 1]],
    "triangle": np.array([(0, 0, 1), (0, 1, 1), (1, 0, 1.5), (1, 0, 1.5)], dtype=float),
    "trapezoid": np.array([(-1, 0, 1), (-0.2, 1, 1), (0.2, 1, 1), (1, 0, 1)], dtype=float),
    "kite": np.array([(0, 0, 1), (-0.5, 0.2, 1), (0, 2, 1), (0.5, 0.2, 1)], dtype=float),
    "sliver": rectangle((0.3, -1, 0.5), (0, 2, 0), (0.01, 0, 0)),
    "through the horizon": rectangle((0.5, -0.5, -0.7), (0, 0, 1), (0, 1, 0))[[0, 3, 2, 1]],
}


def points_at(position, normal=(0, 0, 1), count=1):
    position, normal = (np.array(np.broadcast_to(np.array(vector, dtype=float), (count, 3))) for vector in (
        position, normal))
    return SurfacePoints(position, normal, np.zeros(count, int))


def irradiance(scene, points, samples=1, seed=1, caster=Naive):
    light = DirectLight(scene, caster(scene), Tally(), samples)
    return light.irradiance(points, mix(seed, np.arange(len(points))))


def front_up(polygon):
    """The polygon, turned if need be so that the origin sees its front."""
    return polygon if point_to_polygon([(0, 0, 0)], [(0, 0, 1)], [polygon])[0, 0] > 0 else polygon[::-1]


def triangle_last(polygon):
    """A turned triangle has its repeated corner first: move it to the end."""
    return polygon[[1, 2, 3, 0]][[0, 1, 2, 2]] if (polygon[0] == polygon[1]).all() else polygon


def beyond(polygon, axis, border):
    """The part of a polygon where a coordinate is above a border."""
    parts = []
    for here, there in zip(polygon, np.roll(polygon, -1, axis=0), strict=True):
        low, high = here[axis] - border, there[axis] - border
        if low >= 0:
            parts.append(here)
        if low * high < 0:
            parts.append(here + low / (low - high) * (there - here))
    return np.array(parts)


# Kites and slivers are tried from afar.
@pytest.fixture(params=[name for name in LIGHTS if name not in ("kite", "sliver", "wall")])
def polygon(request):
    return triangle_last(front_up(LIGHTS[request.param]))


def assert_mean_is(values, truth, power):
    """The mean of independent estimates within 3.5 standard errors of the truth, which are a share ``power`` of it."""
    error = values.std(axis=0) / np.sqrt(len(values))
    assert (np.abs(values.mean(axis=0) - truth) < 3.5 * error + 1e-12).all()
    assert (error < power * truth).all(), "too few points for this test to show anything"


def test_single_samples_have_the_closed_form_as_their_mean(polygon):
    values = irradiance(scene_of(RECEIVER, (polygon, LAMP)), points_at((0, 0, 0), count=20000))
    assert_mean_is(values, point_to_polygon([(0, 0, 0)], [(0, 0, 1)], [polygon])[0, 0] * COLOUR, 0.015)


def test_many_samples_of_one_point_meet_the_closed_form(polygon):
    positions = np.random.default_rng(4).uniform(-0.2, 0.2, (40, 3)) * (1, 1, 0)
    points = points_at(positions, count=40)
    values = irradiance(scene_of(RECEIVER, (polygon, LAMP)), points, samples=1024)
    truth = point_to_polygon(points.position, points.normal, [polygon]) * COLOUR
    # Evenly spread samples err far less than 1024 at random, of which the standard error is 4 % near the worst light.
    np.testing.assert_allclose(values, truth, rtol=0.015)


@pytest.mark.parametrize("name", ["triangle", "trapezoid", "kite", "sliver"])
def test_far_lights_have_the_closed_form_as_their_mean_whole_and_half_hidden(name):
    """They are sampled by area: positions must be spread evenly over it, which only a shadow shows from afar."""
    polygon = triangle_last(front_up(LIGHTS[name])) * (1, 1, 0) + (0, 0, 60)
    points = points_at((0, 0, 0), count=8000)
    whole = irradiance(scene_of(RECEIVER, (polygon, LAMP)), points)
    truth = point_to_polygon([(0, 0, 0)], [(0, 0, 1)], [polygon])[0, 0] * COLOUR
    assert_mean_is(whole, truth, 0.01)
    for axis in (0, 1):
        border = polygon[:, axis].mean()
        screen = rectangle((-9, -9, 59.99), (18, 0, 0), (0, 18, 0))
        screen[:, axis] = np.minimum(screen[:, axis], border)
        seen = point_to_polygon([(0, 0, 0)], [(0, 0, 1)], [beyond(polygon, axis, border)])[0, 0] * COLOUR
        assert_mean_is(irradiance(scene_of(RECEIVER, (polygon, LAMP), (screen, BLACK)), points), seen, 0.02)


def test_samples_of_one_point_are_stratified(polygon):
    """Their mean varies less than that of as many independent ones."""
    scene = scene_of(RECEIVER, (polygon, LAMP))
    single, many = (irradiance(scene, points_at((0, 0, 0), count=2000), samples=samples)[:, 0] for samples in (1, 16))
    assert many.std() < 0.6 * single.std() / 4


def test_several_lights_add_up_whatever_their_power_and_distance():
    polygons = [triangle_last(front_up(LIGHTS[name])) for name in ("overhead", "triangle", "through the horizon")]
    polygons[0] = polygons[0] * 3 - (3, 0, 0)
    polygons[2] = polygons[2] * (1, 0.3, 1) - (0, 2, 0)
    scene = scene_of(RECEIVER, *zip(polygons, (LAMP, DIM, DIM), strict=True), (LIGHTS["overhead"] * (1, 1, -1), LAMP))
    factors = point_to_polygon([(0, 0, 0)], [(0, 0, 1)], polygons)[0]
    truth = factors @ [LAMP.emission, DIM.emission, DIM.emission]
    assert_mean_is(irradiance(scene, points_at((0, 0, 0), count=20000)), truth, 0.01)
    np.testing.assert_allclose(irradiance(scene, points_at((0, 0, 0)), samples=1024)[0], truth, rtol=0.02)


def test_a_tilted_normal_weighs_by_its_own_cosine():
    normal = np.array((0.6, 0.0, 0.8))
    polygon = front_up(LIGHTS["overhead"])
    values = irradiance(scene_of(RECEIVER, (polygon, LAMP)), points_at((0.1, 0, 0), normal, 5000))
    assert_mean_is(values, point_to_polygon([(0.1, 0, 0)], [normal], [polygon])[0, 0] * COLOUR, 0.01)


@pytest.mark.parametrize("caster", [Naive, Grid])
def test_an_occluder_hides_the_part_of_a_light_behind_it(caster):
    polygon = front_up(LIGHTS["overhead"])
    hidden = rectangle((-2, -2, 0.999), (2, 0, 0), (0, 4, 0)), BLACK
    values = irradiance(scene_of(RECEIVER, (polygon, LAMP), hidden), points_at((0, 0, 0), count=10000), caster=caster)
    left = np.clip(polygon, (0, -9, -9), 9)
    assert_mean_is(values, point_to_polygon([(0, 0, 0)], [(0, 0, 1)], [left])[0, 0] * COLOUR, 0.015)


def test_an_occluder_just_above_the_point_hides_all():
    scene = scene_of(RECEIVER, (front_up(LIGHTS["overhead"]), LAMP), (rectangle((-1, -1, 1e-6), (2, 0, 0), (0, 2, 0)),
                                                                     BLACK))
    assert not irradiance(scene, points_at((0, 0, 0)), samples=64).any()


@pytest.mark.parametrize("polygon", [
    front_up(LIGHTS["overhead"])[::-1],
    LIGHTS["overhead"] - (0, 0, 2),
    rectangle((-0.5, -0.5, 0), (1, 0, 0), (0, 1, 0)),
    rectangle((1, -1, -1), (0, 2, 0), (0, 0, 1)),
    rectangle((1, -1, -1), (0, 2, 0), (0, 0, 1))[::-1],
], ids=["its back", "below", "in the plane", "up to the horizon", "up to the horizon, turned"])
def test_what_does_not_shine_on_a_point_gives_exactly_nothing(polygon):
    assert not irradiance(scene_of(RECEIVER, (polygon, LAMP)), points_at((0, 0, 0), count=200), samples=4).any()


def test_no_shadow_ray_is_spent_on_what_cannot_shine():
    tally = Tally()
    scene = scene_of(RECEIVER, (front_up(LIGHTS["overhead"])[::-1], LAMP))
    DirectLight(scene, Naive(scene), tally, 16).irradiance(points_at((0, 0, 0)), mix(0, np.arange(1)))
    assert tally.kinds["shadow"]["rays"] == 0


@pytest.mark.parametrize("turn", [1, -1])
def test_a_two_sided_light_shines_from_its_back_as_from_its_front(turn):
    polygon = LIGHTS["trapezoid"]
    scene = scene_of(RECEIVER, (polygon[::turn], LAMP, {"two_sided": True}))
    truth = abs(point_to_polygon([(0, 0, 0)], [(0, 0, 1)], [polygon])[0, 0]) * COLOUR
    assert_mean_is(irradiance(scene, points_at((0, 0, 0), count=5000)), truth, 0.015)


def test_point_lights_follow_inverse_square_and_cosine_exactly():
    positions = np.array([(0.0, 0, 2), (3, 0, 4), (0, -1, 1), (0, 0, -1), (2, 0, 0)])
    lights = [PointLight(position=tuple(position), intensity=(1.0, 2.0, 4.0)) for position in positions]
    shares = np.array([1 / 4, 0.8 / 25, np.sqrt(0.5) / 2, 0, 0]) / np.pi
    for light, share in zip(lights, shares, strict=True):
        value = irradiance(scene_of(RECEIVER, lights=(light,)), points_at((0, 0, 0)))
        np.testing.assert_allclose(value[0], share * np.array((1, 2, 4)), rtol=1e-13)
    value = irradiance(scene_of(RECEIVER, lights=tuple(lights)), points_at((0, 0, 0)))
    np.testing.assert_allclose(value[0], shares.sum() * np.array((1, 2, 4)), rtol=1e-13)


@pytest.mark.parametrize("degrees", [0, 15, 29, 31])
def test_a_spot_lights_within_its_cone_as_a_point_does(degrees):
    angle = np.radians(degrees)
    cone = Cone(direction=(-np.sin(angle), 0, -np.cos(angle)), inner=10, outer=30)
    lights = [PointLight(position=(0, 0, 2), intensity=(1, 2, 4), cone=one) for one in (None, cone)]
    bare, spot = (irradiance(scene_of(RECEIVER, lights=(one,)), points_at((0, 0, 0)))[0] for one in lights)
    np.testing.assert_allclose(spot, cone.factor(np.array([(0.0, 0, 2)]))[0] * bare, rtol=1e-13)
    assert spot.any() == (degrees < 30)


def test_the_sun_lights_with_the_cosine_and_casts_a_sharp_shadow():
    screen = rectangle((0, -1, 1e3), (9e3, 0, 0), (0, 2, 0)), BLACK
    sun = DirectionalLight(direction=(-3, 0, -4), irradiance=(1, 2, 4))
    under, beside = irradiance(scene_of(RECEIVER, screen, lights=(sun,)),
                                       points_at([(0, 0, 0), (-751, 0, 0)], count=2))
    assert not under.any()
    np.testing.assert_allclose(beside, 0.8 / np.pi * np.array((1, 2, 4)), rtol=1e-13)
    assert not irradiance(scene_of(RECEIVER, lights=(sun,)), points_at((0, 0, 0), (0, 0, -1))).any()


def test_a_point_light_casts_a_sharp_shadow():
    screen = rectangle((0, -1, 1), (1, 0, 0), (0, 2, 0)), BLACK
    scene = scene_of(RECEIVER, screen, lights=(PointLight(position=(0, 0, 2), intensity=(1, 1, 1)),))
    value = irradiance(scene, points_at([(0.01, 0, 0), (-0.01, 0, 0)], count=2))
    assert not value[0].any()
    assert value[1].all()


def sheets(count, material):
    return [(rectangle((-2, -2, 0.1 + 0.05 * number), (4, 0, 0), (0, 4, 0)), material) for number in range(count)]


@pytest.mark.parametrize("count", [1, 2, 5, SHEETS])
def test_each_sheet_dims_by_its_transmittance(count):
    tint = np.array((0.9, 0.5, 0.8))
    glass = Material(name="glass", transparent=tuple(tint), refraction_index=1.0)
    lights = PointLight(position=(0, 0, 2), intensity=(1, 1, 1)),
    lamp = front_up(LIGHTS["overhead"]), LAMP
    bare = irradiance(scene_of(RECEIVER, lamp, lights=lights), points_at((0, 0, 0)), samples=16)
    scene = scene_of(RECEIVER, lamp, *sheets(count, glass), lights=lights)
    dimmed = irradiance(scene, points_at((0, 0, 0)), samples=16)
    np.testing.assert_allclose(dimmed, bare * tint**count, rtol=1e-12)


def test_more_sheets_than_are_followed_are_dark():
    glass = Material(name="glass", transparent=(1, 1, 1))
    lamp = front_up(LIGHTS["overhead"]), LAMP
    assert not irradiance(scene_of(RECEIVER, lamp, *sheets(SHEETS + 1, glass)), points_at((0, 0, 0)), samples=4).any()


@pytest.mark.parametrize("position", [0, 1, 3])
def test_an_opaque_patch_among_sheets_blocks(position):
    parts = sheets(4, Material(name="glass", transparent=(0.9, 0.9, 0.9)))
    parts[position] = parts[position][0], BLACK
    assert not irradiance(scene_of(RECEIVER, (LIGHTS["overhead"], LAMP), *parts), points_at((0, 0, 0)), samples=4).any()


def test_a_sheet_behind_the_light_does_not_dim_it():
    glass = rectangle((-2, -2, 1.001), (4, 0, 0), (0, 4, 0)), Material(name="glass", transparent=(0.5, 0.5, 0.5))
    lamp = front_up(LIGHTS["overhead"]), LAMP
    bare, backed = (irradiance(scene_of(RECEIVER, lamp, *more), points_at((0, 0, 0)), samples=8)
                    for more in ((), (glass,)))
    np.testing.assert_allclose(backed, bare, rtol=1e-12)


@pytest.mark.parametrize("height", [1e-2, 1e-4, 1e-7])
def test_a_light_that_touches_the_surface_is_bright_without_sparks_at_its_foot(height):
    """Beside a glowing wall the truth is near 1/2; by area, positions on the wall would count up to 1 / distance^2."""
    wall = rectangle((0, -1, 0), (0, 2, 0), (0, 0, 1))
    points = points_at((height, 0, 0), count=4000)
    values = irradiance(scene_of(RECEIVER, (wall, DIM)), points) / DIM.emission
    truth = point_to_polygon(points.position[:1], points.normal[:1], [wall])[0, 0]
    assert values.max() < 2
    assert_mean_is(values, truth, 0.02)


def test_a_surface_does_not_shade_itself():
    """Rounding puts points of a tilted surface on either side of it."""
    turn = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    floor = rectangle((-1, -1, 0.3), (2, 0, 0), (0, 2, 0)) @ turn
    scene = scene_of((floor, BLACK), lights=(PointLight(position=tuple((0, 0, 2) @ turn), intensity=(1, 1, 1)),))
    normal = scene.normals[0] * np.sign(scene.normals[0] @ turn[2])
    positions = np.append(np.random.default_rng(5).uniform(-1, 1, (200, 2)), np.full((200, 1), 0.3), axis=1) @ turn
    assert irradiance(scene, points_at(positions, normal, 200)).all()


def test_light_depends_on_a_points_key_and_on_no_other_point():
    scene = scene_of(RECEIVER, (front_up(LIGHTS["kite"]), LAMP), (front_up(LIGHTS["overhead"]) * 2, DIM))
    points = points_at(np.random.default_rng(3).uniform(-1, 1, (50, 3)) * (1, 1, 0), count=50)
    keys = mix(1, np.arange(50))
    light = DirectLight(scene, Naive(scene), Tally(), 4)
    whole = light.irradiance(points, keys)
    parts = DirectLight(scene, Naive(scene), Tally(), 4, in_flight=InFlight(shadow=28))
    np.testing.assert_array_equal(parts.irradiance(points, keys), whole)
    rows = np.array([31, 4, 17])
    np.testing.assert_array_equal(light.irradiance(points[rows], keys[rows]), whole[rows])
    assert (light.irradiance(points, mix(2, np.arange(50))) != whole).any(axis=1).all()


def test_no_points_and_no_lights_are_no_trouble():
    assert irradiance(scene_of(RECEIVER, (LIGHTS["kite"], LAMP)), points_at((0, 0, 0), count=0)).shape == (0, 3)
    assert not irradiance(scene_of(RECEIVER), points_at((0, 0, 0))).any()


def test_a_light_does_not_light_itself():
    rng = np.random.default_rng(11)
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    lamp = rectangle((0.3, 0.2, 1.7), *axes[:2])
    scene = scene_of((lamp, LAMP))
    position = rng.random((500, 2)) @ axes[:2] + (0.3, 0.2, 1.7)
    points = SurfacePoints(position, np.tile(scene.normals[0], (500, 1)), np.zeros(500, int))
    assert not irradiance(scene, points, samples=4).any()


def test_samples_of_a_lamp_that_nearly_touches_vary_no_more_than_its_cosine():
    """By its solid angle, almost 2 pi, one sample is twice the cosine: its variance is a third of the square."""
    lamp = rectangle((-0.5, -0.5, 0.01), (0, 1, 0), (1, 0, 0))
    scene = scene_of(RECEIVER, (lamp, Material(name="white lamp", emission=(1, 1, 1))))
    found = irradiance(scene, points_at((0, 0, 0), count=2000))[:, 0]
    assert found.mean() == pytest.approx(1, abs=0.05)
    assert found.std() == pytest.approx(1 / np.sqrt(3), abs=0.05)
