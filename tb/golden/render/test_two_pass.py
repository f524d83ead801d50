import json
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from golden.base.errors import InputError
from golden.base.spread import in_turn
from golden.cast.screen import Screen
from golden.light.direct import DirectLight
from golden.light.indirect import CUTS, EVERY
from golden.light.pixels import Pixels
from golden.light.tone import luminance
from golden.render import two_pass
from golden.render.two_pass import FAINT, RenderSettings, render
from golden.scene.appearance import from_srgb
from golden.scene.builder import SceneBuilder
from golden.scene.builtin.furnace import furnace
from golden.scene.builtin.shapes import FACES, box, framed
from golden.scene.camera import Camera
from golden.scene.lights import DirectionalLight, PointLight
from golden.scene.load import load_scene
from golden.scene.material import Material
from golden.scene.sky.daylight import Daylight
from golden.scene.tessellate import sphere
from golden.scene.texture import Texture
from golden.scene.textures import Textures
from tb.golden.light.scenes import BLACK, rectangle, scene_of
from tb.golden.render.pictures import SMALL, looking, picture
from tb.golden.scene.furnaces import furnace_of, lit_from_above

COLOUR = np.array((4.0, 2.0, 1.0))
LAMP = Material(name="lamp", emission=tuple(COLOUR))
SKY = 0.5, 0.25, 1.0
FLOOR = rectangle((-2, -2, 0), (4, 0, 0), (0, 4, 0))
WIDE = rectangle((-99, -99, 0), (198, 0, 0), (0, 198, 0))
DEEP = np.array((0.0, 0, 3))
MIRROR = Material(name="mirror", specular=(1, 1, 1))
GREY = Material(name="grey", diffuse=(0.5, 0.5, 0.5))


def at_angle(degrees, side=1.0, fov=0.01):
    """A narrow view of the origin at an angle from the z axis, from above (side 1) or below."""
    angle = np.radians(degrees)
    return looking((-np.sin(angle), 0, side * np.cos(angle)), (0, 0, 0), fov)


def fresnel(incident, index):
    """Reflectance at an angle in the thin medium, by the angles of Snell's law (Born and Wolf, 1.5.2)."""
    refracted = np.arcsin(np.sin(incident) / index)
    across = np.sin(incident - refracted) / np.sin(incident + refracted)
    parallel = np.tan(incident - refracted) / np.tan(incident + refracted)
    return (across**2 + parallel**2) / 2


@pytest.fixture
def direct_light_is_one(monkeypatch):
    monkeypatch.setattr(DirectLight, "irradiance", lambda self, points, keys, *ranks: np.ones((len(points), 3)))


@pytest.mark.usefixtures("direct_light_is_one")
@pytest.mark.parametrize("diffuse", [0.5, 0.8])
@pytest.mark.parametrize("method", ["grid", "naive"])
def test_a_white_furnace_shines_alike_everywhere(diffuse, method):
    """All but the noise of shadow rays, instead of which the walls' direct light, 1, is put in."""
    image = picture(furnace_of(2, diffuse=diffuse), width=16, height=16, max_edge=0.3, method=method).image
    np.testing.assert_allclose(image, 1 / (1 - diffuse), rtol=1e-4)


def test_a_white_furnace_shines_alike_within_the_noise_of_its_shadow_rays():
    """No sparks in the corners, where the walls are close."""
    image = picture(furnace(1), width=20, height=20, light_samples=256, max_edge=0.3).image
    np.testing.assert_allclose(image, 2, rtol=0.05)
    assert image.mean() == pytest.approx(2, rel=0.002)


def test_emitters_and_background_are_seen_as_they_are():
    panel = rectangle((-9, 0, 1), (9, 0, 0), (0, 9, 0))
    image = picture(scene_of((panel[::-1], LAMP), background=SKY), looking((0, 0, 0), (0, 0, 1), 60)).image
    seen = (image == COLOUR).all(axis=2)
    assert 0.1 < seen.mean() < 0.9
    assert (image[~seen] == SKY).all()


def test_received_light_is_that_of_the_surface_that_a_pixel_shows():
    """On a lamp and on a black floor too, which reflect none of it, and not beside them."""
    sun = DirectionalLight(direction=(0, 0, -1), irradiance=tuple(np.pi * COLOUR))
    camera = looking((0, 0, 5), (0, 0, 0), 60)
    for material in (BLACK, LAMP, MIRROR):
        scene = scene_of((FLOOR, material), lights=(sun,))
        result = render(scene, camera=camera, settings=RenderSettings(**SMALL), with_received=True)
        shown = result.received > 0
        assert 0.3 < shown.mean() < 0.9
        np.testing.assert_allclose(result.received[shown], luminance(COLOUR), rtol=1e-12)
    assert picture(scene, camera).received is None


def test_a_sky_is_seen_by_direction_and_lights_a_floor():
    """The zenith is three times as bright as the horizon; a floor in the open reflects a half of its irradiance."""
    scene = Daylight(sky="cie-overcast", sky_illuminance=7 * np.pi / 9, ground=0.0).scene(
        scene_of((FLOOR, GREY)), 1.0)
    up = picture(scene, looking((0, 0, 1), (0, 0, 9), 1)).image
    np.testing.assert_allclose(up, 1, rtol=1e-3)
    low = picture(scene, looking((0, 0, 1), (1e3, 0, 1.5), 0.01)).image
    np.testing.assert_allclose(low, 1 / 3, rtol=5e-3)
    floor = picture(scene, looking((0, 0, 1), (0, 0, 0), 1), rays=(256, 64)).image
    np.testing.assert_allclose(floor, 0.5 * 7 / 9, rtol=1e-3)


def test_the_back_of_a_one_sided_lamp_is_black_and_that_of_a_two_sided_one_is_not():
    panel = rectangle((-9, -9, 1), (18, 0, 0), (0, 18, 0))
    camera = looking((0, 0, 0), (0, 0, 1))
    assert not picture(scene_of((panel, LAMP), background=SKY), camera).image.any()
    assert (picture(scene_of((panel, LAMP, {"two_sided": True})), camera).image == COLOUR).all()


def test_a_wall_of_two_colours_reflects_on_each_side_its_own(tmp_path):
    """Under a uniform sky of 1 a wall alone shows its reflectance, and of the lamp behind it nothing."""
    (tmp_path / "wall.mtl").write_text(
        "newmtl red\nKd 0.8 0.1 0\nnewmtl blue\nKd 0.1 0.2 0.6\nnewmtl lamp\nKd 0 0 0\nKe 1 1 1\n")
    (tmp_path / "wall.obj").write_text(
        "mtllib wall.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 3 0 0\nv 3 1 0\nusemtl red\nf 1 2 3\nf 1 3 4\n"
        "usemtl blue\nf 4 3 1\nf 3 2 1\nusemtl lamp\nf 2 5 6\nf 2 6 3\nusemtl red\nf 6 5 2\nf 3 6 2\n")
    scene = replace(load_scene(tmp_path / "wall.obj"), background=(1.0, 1, 1))
    assert (len(scene), scene.two_sided.any()) == (4, False)
    for x, colours in ((0.5, [(0.8, 0.1, 0), (0.1, 0.2, 0.6)]), (2, [(1, 1, 1), (0.8, 0.1, 0)])):
        for side, colour in zip((3, -3), colours, strict=True):
            image = picture(scene, looking((x, 0.5, side), (x, 0.5, 0), 1), rays=(128, 32)).image
            np.testing.assert_allclose(image, np.broadcast_to(colour, image.shape), atol=2e-3)


def test_a_flat_perfect_mirror_shows_the_lamp_and_without_depth_nothing():
    lamp = rectangle((4, -5, 0), (0, 10, 0), (0, 0, 10))[[0, 3, 2, 1]]
    scene = scene_of((FLOOR, MIRROR), (lamp, LAMP))
    camera = at_angle(45, fov=5)
    np.testing.assert_allclose(picture(scene, camera, depth=1).image, np.broadcast_to(COLOUR, (10, 12, 3)), rtol=1e-12)
    assert not picture(scene, camera, depth=0).image.any()


def test_a_mirror_shows_the_mirror_image():
    """A lamp behind the camera, seen in the mirror, and the same one turned over in place of the mirror."""
    lamp = np.array([(0, -5, 3), (0, 5, 3), (5, 5, 3), (5, -5, 3)], dtype=float)
    camera = Camera(eye=(0.3, 0.2, 2.0), target=(0.1, 0, 0), up=(0, 1, 0), fov=20)
    mirrored = picture(scene_of((FLOOR, MIRROR), (lamp, LAMP)), camera, width=24, height=24).image
    straight = picture(scene_of((lamp[::-1] * (1, 1, -1), LAMP)), camera, width=24, height=24).image
    np.testing.assert_allclose(mirrored, straight, rtol=1e-12)
    assert 0.1 < (straight[..., 0] > 0).mean() < 0.9


@pytest.mark.parametrize("body", [
    sphere((0, 0, 0), 1.0, segments=12), FLOOR @ np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0],
], ids=["ball", "turned plane"])
def test_no_ray_is_mirrored_into_the_mirror(body):
    """Neither by a ball's normals on facets nor by a rounding: all of the uniform sky comes back."""
    scene = scene_of((body, MIRROR, {"smooth": len(body.shape) == 3, "two_sided": len(body.shape) == 2}),
                     background=(1.0, 1.0, 1.0))
    image = picture(scene, looking((1.5, 2, 3), (0, 0, 0), 30), width=24, height=24).image
    np.testing.assert_allclose(image, 1, rtol=1e-12)


def test_the_back_of_a_one_sided_mirror_is_black():
    assert not picture(scene_of((FLOOR, MIRROR), background=SKY), at_angle(20, side=-1)).image.any()


@pytest.mark.parametrize("depth", [1, 4, 9])
def test_depth_is_the_number_of_mirrors_that_a_ray_meets(depth):
    """Between two facing mirrors that glow every bounce adds the glow, a tenth less."""
    glow = Material(name="glow", specular=(0.9, 0.9, 0.9), emission=(1, 1, 1))
    scene = scene_of((WIDE, glow), (WIDE[::-1] + 0.5, glow))
    image = picture(scene, looking((0, 0, 0.3), (0, 0, 0), 1), depth=depth).image
    np.testing.assert_allclose(image, sum(0.9**bounce for bounce in range(depth + 1)), rtol=1e-9)


def test_the_faint_end_of_a_chain_of_mirrors_is_dropped():
    dim = Material(name="dim", specular=(0.1, 0.1, 0.1), emission=(1, 1, 1))
    result = picture(scene_of((WIDE, dim), (WIDE[::-1] + 0.5, dim)), looking((0, 0, 0.3), (0, 0, 0), 1), depth=60)
    reflections = int(np.floor(np.log(FAINT) / np.log(0.1)))
    assert result.stats["rays"]["reflection"]["rays"] == 120 * reflections
    np.testing.assert_allclose(result.image, 1 / 0.9, rtol=2 * FAINT)


@pytest.mark.parametrize("degrees", [0, 30, 80])
@pytest.mark.parametrize("side", [1, -1])
def test_a_sheet_of_index_one_lets_light_pass_straight_on(degrees, side):
    tint = np.array((0.9, 0.5, 0.25))
    sheet = FLOOR, Material(name="sheet", transparent=tuple(tint), refraction_index=1.0)
    panel = rectangle((-0.2, -0.1, -0.5 * side), (0.3, 0, 0), (0, 0.3, 0)), LAMP, {"two_sided": True}
    camera = at_angle(degrees, side, 40)
    bare, tinted = (picture(scene_of(panel, *more, background=SKY), camera).image for more in ((), (sheet,)))
    behind = np.abs(tinted / bare - tint).max(axis=2) < 1e-9
    beside = (tinted == bare).all(axis=2)
    assert (behind | beside).all()
    assert behind.mean() > 0.3
    assert len(np.unique(bare[behind], axis=0)) == 2 or degrees == 80


@pytest.mark.parametrize("degrees", [1, 30, 60, 85])
def test_reflected_and_refracted_light_have_fresnels_shares(degrees):
    """Glass below, an emitter under it, and the sky above."""
    scene = scene_of((WIDE, Material(name="glass", transparent=(1, 1, 1))), (WIDE - DEEP, LAMP), background=SKY)
    share = fresnel(np.radians(degrees), 1.5)
    image = picture(scene, at_angle(degrees)).image
    np.testing.assert_allclose(image[5, 6], share * np.array(SKY) + (1 - share) * COLOUR, rtol=1e-3)


@pytest.mark.parametrize("degrees", [20, 50, 75])
@pytest.mark.parametrize("index", [1.33, 2.4])
def test_refracted_rays_follow_snells_law(degrees, index):
    """A small emitter under the surface, where the law leads a ray through the origin, fills the view."""
    incident = np.radians(degrees)
    offset = np.tan(np.arcsin(np.sin(incident) / index))
    target = rectangle((offset - 0.005, -0.005, -1), (0.01, 0, 0), (0, 0.01, 0))
    glass = Material(name="glass", transparent=(1, 1, 1), refraction_index=index)
    image = picture(scene_of((FLOOR, glass), (target, LAMP)), at_angle(degrees)).image
    np.testing.assert_allclose(image, np.broadcast_to((1 - fresnel(incident, index)) * COLOUR, image.shape), rtol=1e-3)


@pytest.mark.parametrize(("degrees", "total"), [(30, False), (41, False), (42.5, True), (70, True)])
def test_light_inside_glass_is_reflected_totally_beyond_the_critical_angle(degrees, total):
    """Seen from below; the critical angle of index 1.5 is 41.8 degrees."""
    scene = scene_of((WIDE, Material(name="glass", transparent=(1, 1, 1))), (WIDE - DEEP, LAMP), background=SKY)
    image = picture(scene, at_angle(degrees, side=-1)).image[5, 6]
    share = 1 if total else fresnel(np.arcsin(1.5 * np.sin(np.radians(degrees))), 1.5)
    np.testing.assert_allclose(image, share * COLOUR + (1 - share) * np.array(SKY), rtol=2e-3)


@pytest.mark.parametrize("body", [box((-1, -1, -1), (1, 1, 1)), sphere((0, 0, 0), 1.0, segments=48)],
                         ids=["block", "ball"])
def test_glass_neither_adds_nor_loses_light(body):
    """A clear body in a uniform sky cannot be seen, but for the faint rays that are dropped.

    A ball of facets with a ball's normals keeps a few grazing rays inside for ever.
    """
    glass = body, Material(name="glass", transparent=(1, 1, 1)), {"smooth": len(body) > 6}
    camera = looking((1.5, 2, 3), (0, 0, 0), 30)
    image = picture(scene_of(glass, background=(1, 1, 1)), camera, depth=12, width=24, height=20).image
    assert image.max() <= 1 + 1e-12
    assert np.quantile(image, 0.05) > 1 - 10 * FAINT
    assert image.mean() > 1 - 5 * FAINT


def test_whole_numbers_are_as_good_as_any_for_a_background():
    scenes = [scene_of((FLOOR * 0.01, Material(name="dim", emission=(0.5, 0.5, 0.5))), background=sky)
              for sky in ((1, 0, 2), (1.0, 0.0, 2.0))]
    whole, real = (picture(scene, at_angle(0, fov=5)).image for scene in scenes)
    np.testing.assert_array_equal(whole, real)
    assert 0.5 in real


def test_what_diffuse_mirror_and_glass_share_adds_up_under_a_uniform_sky():
    mixed = Material(name="mixed", diffuse=(0.5, 0.2, 0), specular=(0.2, 0.3, 0.4), transparent=(0.3, 0.5, 0.6))
    image = picture(scene_of((FLOOR, mixed), background=(1, 1, 1)), at_angle(50, fov=20)).image
    np.testing.assert_allclose(image, 1, rtol=1e-9)


def test_each_point_is_shaded_with_its_own_random_numbers(monkeypatch):
    """Those that mirrored and refracted rays of one hit meet, too."""
    seeds = []

    def irradiance(light, points, keys, rank=None):
        # Others are of elements, or where rays that gather light end.
        if light._samples == SMALL["light_samples"]:
            seeds.append(np.stack([keys, rank.astype(np.uint64)], axis=1))
        return np.ones((len(points), 3))
    monkeypatch.setattr(DirectLight, "irradiance", irradiance)
    wall = Material(name="wall", diffuse=(0.5, 0.5, 0.5))
    sheet = FLOOR, Material(name="sheet", transparent=(0.5, 0.5, 0.5), specular=(0.5, 0.5, 0.5), thin=True)
    result = picture(scene_of(sheet, (WIDE - DEEP, wall), (WIDE[::-1] + DEEP, wall), background=SKY), at_angle(20),
                     samples=4)
    assert result.stats["rays"]["reflection"]["hits"] == result.stats["rays"]["refraction"]["hits"] == 480
    seeds = np.concatenate(seeds)
    assert len(np.unique(seeds, axis=0)) == len(seeds) == 960


@pytest.mark.parametrize("side", [1, 2, 3, 5])
def test_random_primary_rays_of_a_pixel_share_no_column_row_or_field(side):
    screen = Screen(camera=looking((0, 0, 1), (0, 0, 0)), width=7, height=5)
    within = Pixels(None, None, screen, RenderSettings(samples=side**2), False)._within(np.arange(35))
    field = np.stack([np.arange(side**2) % side, np.arange(side**2) // side], axis=1)
    line = ((field + within.reshape(35, side**2, 2)) * side).astype(int)
    assert ((within >= 0) & (within < 1)).all()
    np.testing.assert_array_equal(np.sort(line, axis=1), np.broadcast_to(np.arange(side**2)[:, None], line.shape))


def test_a_tessellated_ball_is_shaded_smoothly():
    """Under a point light at the eye its brightness follows the cosine of the ball, not of its facets."""
    light = PointLight(position=(0.0, 0.0, 9.0), intensity=(81.0, 81.0, 81.0))
    white = Material(name="white", diffuse=(1, 1, 1))
    scene = scene_of((sphere((0, 0, 0), 1.0, segments=24), white, {"smooth": True}), lights=(light,))
    image = picture(scene, looking((0, 0, 9), (0, 0, 0), 9), width=60, height=60).image[..., 0]
    y, x = (np.mgrid[:60, :60] - 29.5) / 60 * 2 * np.tan(np.radians(4.5)) * 9
    inside = np.hypot(x, y) < 0.6
    lit = np.sqrt(1 - (x**2 + y**2)[inside]) * 81 / np.pi / (9 - np.sqrt(1 - (x**2 + y**2)[inside])) ** 2
    assert np.abs(image[inside] / lit - 1).max() < 0.12
    assert np.abs(image[inside] / lit - 1).mean() < 0.03


@pytest.fixture(scope="module")
def room():
    """Diffuse, mirror and glass in one closed room with a lamp."""
    glass = Material(name="glass", transparent=(0.9, 0.9, 0.9))
    ball = sphere((0.6, 0.5, 0.3), 0.2, segments=8), glass, {"smooth": True}
    mirror = rectangle((0.2, 0.9, 0.1), (0.6, 0, 0), (0, 0, 0.6)), MIRROR
    walls = lit_from_above(1)
    grey = Material(name="grey", diffuse=(0.5, 0.4, 0.3))
    return scene_of((walls.vertices[:5], grey), (walls.vertices[5:], LAMP), ball, mirror, camera=walls.camera)


ROOM = {"samples": 4, "max_edge": 0.34}


@pytest.fixture(scope="module")
def image_of_room(room):
    return picture(room, **ROOM)


def test_light_of_a_window_is_without_grain_beside_bodies():
    """Few of the rays that gather it pass through the window: as many as beside lamps leave 7 % of noise."""
    builder = SceneBuilder("room with a window")
    for number, wall in enumerate(box((0, 0, 0), (4, 5, 2.8))[:, ::-1]):
        builder.add(framed(wall, border=0.8)[:4] if number == FACES.index("-y") else wall, GREY, two_sided=True)
    builder.add(box((1.5, 2.5, 0), (2.5, 3.5, 0.5), omit=("-z",)), GREY)
    scene = builder.build(background=(1.0, 1.0, 1.0))
    one, other = (picture(scene, looking((2, 1.6, 1.5), (2, 2.4, 0), 12), width=32, height=32, samples=4, rays=(32, 16),
                          max_edge=None, elements=200, method="grid", seed=seed).image for seed in range(2))
    noise = (one - other) * np.sqrt(2) / (one + other)
    assert 0.005 < np.sqrt((noise**2).mean()) < 0.03


def test_another_seed_gives_another_image_of_the_same_thing(room, image_of_room):
    other = picture(room, seed=1, **ROOM).image
    assert (other != image_of_room.image).mean() > 0.5
    assert other.mean() == pytest.approx(image_of_room.image.mean(), rel=0.05)


def test_the_solver_is_the_requested_one():
    names = ("gauss-jacobi", "progressive", "conjugate-gradient")
    assert len({picture(furnace(1), solver=name, width=2, height=2, light_samples=1).stats["solver"]["steps"]
                for name in names}) == len(names)


def test_samples_of_a_pixel_cover_it_evenly():
    """The border of a lamp through the middle of the pixels: each takes half its fields, at most a row of them errs."""
    panel = rectangle((0, -9, 1), (0, 18, 0), (9, 0, 0))
    camera = looking((0, 0, 0), (0, 0, 1), 40)
    image = picture(scene_of((panel, LAMP)), camera, width=1, height=40, samples=64).image
    shares = (image / COLOUR)[:, 0, 0]
    np.testing.assert_allclose(shares, 0.5, atol=1 / 16)


def test_stats_have_what_was_promised_and_add_up(room, image_of_room):
    stats = image_of_room.stats
    assert json.loads(json.dumps(stats)) == stats
    assert set(stats) == {"scene", "settings", "patches", "elements", "nodes", "solver", "rays", "total",
                          "tests_per_ray", "steps_per_ray", "seconds", "not_computed", "noise"}
    assert set(stats["rays"]) == {"hemisphere", "transmission", "shadow", "primary", "reflection", "refraction",
                                  "gather"}
    assert set(stats["seconds"]) == {"cells", "elements", "form factors", "direct light of elements", "solver",
                                     "adaptive refinement", "light near nodes", "image"}
    for count in ("rays", "hits", "tests", "steps"):
        assert stats["total"][count] == sum(kind[count] for kind in stats["rays"].values())
    assert stats["patches"] == len(room)
    assert stats["rays"]["primary"]["rays"] == stats["rays"]["primary"]["hits"] == 120 * 4
    assert stats["rays"]["hemisphere"]["rays"] == stats["nodes"] * 64
    assert stats["tests_per_ray"] == stats["total"]["tests"] / stats["total"]["rays"]
    assert stats["steps_per_ray"] == stats["total"]["steps"] / stats["total"]["rays"]
    assert stats["settings"]["rays"] == [16, 4]
    assert stats["settings"]["max_edge"] == 0.34
    assert stats["solver"]["converged"]


def test_an_estimate_bounds_the_hemispheres_and_counts_none(room, image_of_room):
    estimates = []
    result = render(room, camera=room.camera, settings=RenderSettings(**(SMALL | ROOM)),
                    estimate=lambda *values: estimates.append(values))
    assert result.stats["rays"] == image_of_room.stats["rays"]
    (most, seconds), = estimates
    cut = len(result.indirect.elements) // EVERY
    assert most - len(result.indirect.irradiance) == (CUTS + 1)**2 * cut
    assert result.indirect.nodes <= most
    assert seconds > 0


def test_heat_maps_hold_every_test_and_step_of_the_picture(image_of_room):
    for name in ("tests", "steps"):
        heat = getattr(image_of_room, name)
        assert heat.shape == (10, 12)
        assert heat.dtype == np.int64
        assert heat.sum() == sum(image_of_room.stats["rays"][kind][name]
                                 for kind in ("primary", "reflection", "refraction"))


def test_default_elements_and_rays_are_about_as_many_as_aimed_at():
    result = picture(furnace(1), width=2, height=2, elements=90, max_edge=None, light_samples=1)
    assert result.stats["elements"] == 6 * 4 * 4
    result = picture(furnace(1), width=2, height=2, rays=None, light_samples=1)
    assert result.stats["settings"]["rays"] == [256, 64]
    grids, most = two_pass.ELEMENT_GRIDS, two_pass.ELEMENT_RAYS
    assert [two_pass._hemisphere_rays(count, grids, most) for count in (366, 367, 5859, 5860, 99999)] == \
        [(256, 64), (128, 32), (64, 16), (32, 16), (32, 16)]


@pytest.mark.parametrize(("bad", "message"), [
    ({"width": 0}, "Width must be 1 to 16384, not 0"),
    ({"height": 16385}, "Height must be 1 to 16384, not 16385"),
    ({"height": 2.0}, "Height must be 1 to 16384, not 2.0"),
    ({"samples": True}, "Samples must be 1 to 1024, not True"),
    ({"width": 16384, "height": 4097}, "Size must be at most 67108864 pixels, not 16384 x 4097"),
    ({"samples": 0}, "Samples must be 1 to 1024, not 0"),
    ({"samples": 1025}, "Samples must be 1 to 1024, not 1025"),
    ({"samples": 3}, "Samples must be a square number (1, 4, 9, 16 ... 1024), not 3; the nearest ones are 1 and 4"),
    ({"light_samples": 0}, "Light samples must be 1 to 1024, not 0"),
    ({"noise": 0.0009}, "Noise must be 0.001 to 1, not 0.0009"),
    ({"noise": float("nan")}, "Noise must be 0.001 to 1, not nan"),
    ({"noise": "2%"}, "Noise must be 0.001 to 1, not '2%'"),
    ({"noise": 0.02, "samples": 1}, "Samples must be at least 4 where noise is estimated, not 1"),
    ({"depth": -1}, "Depth must be 0 to 64, not -1"),
    ({"depth": 65}, "Depth must be 0 to 64, not 65"),
    ({"seed": -1}, "Seed must be 0 to 9223372036854775807, not -1"),
    ({"method": "shelling", "width": 2048, "height": 2049}, "Size times samples must be at most 4194304 rays, 65536 "
     "across, by method shelling, not 16785408"),
    ({"method": "shelling", "width": 16384, "height": 1, "samples": 25}, "Size times samples must be at most 4194304 "
     "rays, 65536 across, by method shelling, not 409600"),
    ({"method": "magic"}, "Method must be one of grid, naive, embree, shelling, naive-fixed, not 'magic'"),
])
def test_settings_out_of_range_are_refused(bad, message):
    with pytest.raises(InputError) as error:
        RenderSettings(**bad)
    assert str(error.value) == message


def test_settings_may_be_whole_numbers_of_numpy():
    assert RenderSettings(width=np.int64(64), samples=np.uint8(4)) == RenderSettings(width=64)


def test_unknown_solvers_are_refused_with_the_known_ones():
    with pytest.raises(InputError, match=r"^Solver must be one of gauss-jacobi, .*, conjugate-gradient, not 'guess'$"):
        RenderSettings(solver="guess")


@pytest.mark.parametrize(("bad", "message"), [
    ({"rays": (48, 16)}, "hemisphere: Azimuths must be a power of two from 4 to 4096, not 48"),
    ({"rays": (64, 2)}, "hemisphere: Polars must be a power of two from 4 to 4096, not 2"),
    ({"max_edge": 0.0}, "refinement: Max edge must be a finite value above 0, not 0.0"),
    ({"max_edge": None, "max_area": -1.0}, "refinement: Max area must be a finite value above 0, not -1.0"),
    ({"cell": 2.0}, "Cell size must be 1/256 to 1 of the scene's longest side, not 2.0"),
])
def test_settings_that_do_not_fit_the_scene_are_refused(bad, message):
    with pytest.raises(InputError) as error:
        picture(scene_of((FLOOR, LAMP)), at_angle(0), **bad)
    assert str(error.value) == message


def test_a_scene_without_light_is_refused():
    with pytest.raises(InputError) as error:
        picture(scene_of((FLOOR, BLACK)), at_angle(0))
    assert str(error.value) == ("scene 'test': it has no light: no material emits, and it has no point light and "
                                "no background")


@pytest.mark.parametrize(("method", "expected"), [
    ("grid", [3]), ("embree", [3]), ("naive", [1]), ("shelling", [])])
def test_threads_share_the_work_of_casters_with_threads(monkeypatch, method, expected):
    thread_counts = []
    monkeypatch.setattr(two_pass, "in_threads", lambda jobs: thread_counts.append(jobs) or in_turn)
    picture(furnace(1), jobs=3, method=method, width=2, height=2, rays=(4, 4))
    assert thread_counts == expected


CHECKS = np.array([[(255, 40, 0), (20, 250, 130)], [(90, 90, 255), (230, 230, 40)]], dtype=np.uint8)
"""The floor's quarters, those of larger y first."""


def checked(shares, *, painted):
    """A floor under a lamp beside a grey wall: one patch with a picture of its quarters, or four patches."""
    lamp = rectangle((-1, 1, 3), (2, 0, 0), (0, -2, 0))
    wall = rectangle((2, -2, 0), (0, 4, 0), (0, 0, 3))[..., ::-1, :]
    linear = from_srgb(CHECKS / 255)
    others = {name: (share,) * 3 for name, share in shares.items()}
    camera = Camera(eye=(-1, -6, 4), target=(0.5, 0, 0.5), fov=55)
    if not painted:
        quarters = [(rectangle((x, y, 0), (2, 0, 0), (0, 2, 0)),
                     Material(name=f"{row}{column}", diffuse=tuple(np.minimum(0.5 * linear[row, column],
                                                                             1 - others.get("specular", (0,))[0])),
                              **others))
                    for row, y in enumerate((0, -2)) for column, x in enumerate((-2, 0))]
        return replace(scene_of(*quarters, (lamp, LAMP), (wall, GREY)), camera=camera)
    mean = linear.mean(axis=(0, 1))
    scene = scene_of((FLOOR, Material(name="floor", diffuse=tuple(0.5 * mean), **others)), (lamp, LAMP), (wall, GREY))
    mapping = np.zeros((3, 2, 4))
    mapping[0] = [(0.25, 0, 0, 0.5), (0, 0.25, 0, 0.5)]
    pixels = np.kron(CHECKS, np.ones((64, 64, 1), dtype=np.uint8))
    return replace(scene, camera=camera, textures=Textures(
        pictures=(Texture(Image.fromarray(pixels)),), picture=np.array([0, -1, -1]), mapping=mapping,
        colour=np.tile(mean, (3, 1))))


@pytest.mark.parametrize("shares", [
    pytest.param({}, marks=pytest.mark.nightly), {"specular": 0.7}])
def test_a_picture_on_a_patch_reflects_like_patches_of_its_colours(shares):
    """In the picture, in mirrors and from elements; a floor's shares are at most 1."""
    settings = {"width": 64, "height": 48, "samples": 4, "light_samples": 16, "rays": (64, 16), "max_edge": 0.5}
    one, four = (picture(checked(shares, painted=painted), **settings).image for painted in (True, False))
    # But for the edges of the quarters, between which the picture's colours are interpolated.
    assert np.quantile(np.abs(one - four), 0.995) < 0.05 * four.max()
    assert one.mean(axis=(0, 1)) == pytest.approx(four.mean(axis=(0, 1)), rel=0.01)
    # The wall shows the colours of the floor next to it.
    assert np.median(np.abs(one - four)) < 0.005 * four.mean()
