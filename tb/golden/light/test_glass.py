from contextlib import nullcontext

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from benchmarks.analytic import point_to_polygon
from golden.base.errors import InputError
from golden.cast.grid import Grid
from golden.cast.hemisphere import Hemisphere
from golden.cast.rays import Rays
from golden.light.form_factors import hemisphere_sums
from golden.light.glass import SHEETS, ClearRays, Glass
from golden.light.photometry.sensors import Sensors
from golden.light.solvers.on_demand import Shooting
from golden.render.two_pass import RenderSettings, render
from golden.scene.builtin.shapes import box
from golden.scene.camera import Camera
from golden.scene.lights import PointLight
from golden.scene.material import Material
from golden.scene.tessellate import sphere
from tb.golden.light.scenes import BLACK, rectangle, scene_of, solved
from tb.lib.schedules import SETTINGS

PANE = Material(name="pane", transparent=(0.9, 0.9, 0.9), thin=True)
RED = Material(name="red", transparent=(0.9, 0.3, 0.0), thin=True)
BODY = Material(name="body", transparent=(1, 1, 1))
FLOOR = rectangle((-0.01, -0.01, 0), (0.02, 0, 0), (0, 0.02, 0))
WIDE = rectangle((-1e4, -1e4, 1), (2e4, 0, 0), (0, 2e4, 0))
FEW = {"width": 4, "height": 4, "samples": 1, "light_samples": 4, "max_edge": 1.0, "rays": (32, 8)}


def lifted(number):
    """One of several panes."""
    return WIDE + np.array((0, 0, 0.1 * number))


def surface(cosine, index=1.5):
    """Reflectance of one surface by the angles of Snell's law (Born and Wolf, 1.5.2)."""
    incident = np.arccos(np.minimum(cosine, 1 - 1e-9))
    refracted = np.arcsin(np.sin(incident) / index)
    across = np.sin(incident - refracted) / np.sin(incident + refracted)
    parallel = np.tan(incident - refracted) / np.tan(incident + refracted)
    return (across**2 + parallel**2) / 2


def sheet(cosine):
    """What a pane of index 1.5 lets pass by the endless sum over reflections to and fro."""
    once = surface(cosine)
    return (1 - once) ** 2 * sum(once ** (2 * times) for times in range(600))


def sky_share(scene, channel=0, rays=(256, 64)):
    """Share of the light of the sky above that arrives at the origin, facing +z."""
    caster, hemisphere = Grid(scene), Hemisphere(*rays)
    clear = ClearRays(scene, Glass(scene), caster, channel)
    sums = hemisphere_sums(caster, hemisphere, [(0, 0, 0)], [(0, 0, 1)], scene.surface[:1], columns=len(scene),
                           column_of=lambda direction, hits: hits.patch, clear=clear,
                           sky=lambda direction: np.repeat(direction[:, 2:] > 0, 3, axis=1))
    assert sums.weights.sum() == sums.row_sums[0]
    return sums.light[0, channel] / 2**sums.weight_bits


@pytest.mark.parametrize("degrees", [0, 20, 45, 60, 75, 85, 89])
def test_a_pane_lets_pass_by_angle_what_theory_says(degrees):
    cosine = np.cos(np.radians(degrees))
    glass = Glass(scene_of((FLOOR, PANE), (WIDE, BODY)))
    patches, cosines = np.array([0, 1]), np.full(2, cosine)
    np.testing.assert_allclose(glass.passed(patches, cosines)[:, 0], [0.9 * sheet(cosine), 1 - surface(cosine)],
                               rtol=1e-6)
    assert glass.passed(patches, cosines)[0, 0] <= 0.9
    assert degrees or glass.passed(patches, cosines)[1, 0] == pytest.approx(0.96)


def test_diffuse_light_passes_with_the_mean_over_its_angles():
    glass = Glass(scene_of((FLOOR, PANE), (WIDE, BODY), (FLOOR, BLACK)))
    for patch, share in ((0, lambda cosine: 0.9 * sheet(cosine)), (1, lambda cosine: 1 - surface(cosine))):
        mean, _ = quad(lambda cosine, share=share: 2 * cosine * share(cosine), 1e-6, 1)
        assert glass.mean_passed[patch] == pytest.approx(np.full(3, mean), rel=1e-4)
    assert not glass.mean_passed[2].any()


@pytest.mark.parametrize("count", [1, 2, 3])
def test_a_patch_under_panes_below_a_uniform_sky_gets_the_mean_of_what_passes(count):
    panes = [(lifted(number), PANE) for number in range(count)]
    mean, _ = quad(lambda cosine: 2 * cosine * (0.9 * sheet(cosine)) ** count, 1e-6, 1)
    assert sky_share(scene_of((FLOOR, BLACK), *panes)) == pytest.approx(mean, rel=2e-3)


def test_a_patch_in_a_glass_box_gets_what_its_faces_let_pass():
    """A pane as a body has two surfaces; reflections to and fro between them are left out."""
    block = scene_of((FLOOR, BLACK), (WIDE, BODY), (lifted(1)[::-1], BODY))
    mean, _ = quad(lambda cosine: 2 * cosine * (1 - surface(cosine)) ** 2, 1e-6, 1)
    assert sky_share(block) == pytest.approx(mean, rel=2e-3)


def test_a_sheet_throws_what_it_mirrors():
    """Above a floor of one radiance, and below nothing, a place that faces up sees the floor in the pane."""
    ground = rectangle((-1e4, -1e4, -1), (2e4, 0, 0), (0, 2e4, 0))
    scene = scene_of((FLOOR, BLACK), (WIDE, PANE), (ground, BLACK))
    clear = ClearRays(scene, Glass(scene), Grid(scene), 0)
    sums = hemisphere_sums(Grid(scene), Hemisphere(256, 64), [(0, 0, 0)], [(0, 0, 1)], scene.surface[:1],
                           columns=len(scene), column_of=lambda direction, hits: hits.patch, clear=clear)
    factors = sums.weights.toarray()[0] / 2**sums.weight_bits
    mean, _ = quad(lambda cosine: 2 * cosine * 0.9 * (1 - sheet(cosine)), 1e-6, 1)
    # The place itself is not seen: some of what is mirrored straight back.
    assert factors[2] == pytest.approx(mean, rel=0.01)
    assert factors[1] == pytest.approx(0.1, rel=0.01)


def test_what_rays_do_depends_on_no_others_and_of_mirrored_ones_all_goes_on():
    draw = np.random.default_rng(5)
    scene = scene_of((FLOOR, BLACK), (WIDE, PANE), (lifted(-30), BODY), (lifted(-40), SILVER))
    rays = Rays(draw.uniform(-1, 1, (60, 3)) * (9, 9, 50), draw.normal(size=(60, 3)), source=np.full(60, -1))
    caster, glass = Grid(scene), Glass(scene)
    rays = rays[caster.nearest(rays).patch >= 0]
    hits, clear, mirrored = caster.nearest(rays), ClearRays(scene, glass, caster, 0), np.arange(len(rays)) % 3 == 0
    cosine = np.abs(np.einsum("kj,kj->k", rays.direction, scene.normals[hits.patch]))
    cosine /= np.linalg.norm(rays.direction, axis=1)
    passed, thrown = (share(hits.patch, cosine)[:, 0] for share in (glass.passed, glass.thrown))
    is_sheet, weight = hits.patch == 1, np.full(len(rays), 1 << 20)
    assert 5 < (mirrored & is_sheet).sum() < is_sheet.sum() - 5
    np.testing.assert_array_equal(clear.passed(rays, hits, weight, mirrored), np.rint(
        weight * (passed + np.where(mirrored & is_sheet, thrown, 0))))
    np.testing.assert_array_equal(clear.thrown(rays, hits, weight, mirrored)[is_sheet], np.rint(
        weight * np.where(mirrored, 0, thrown))[is_sheet])


def test_sheets_diffuse_what_they_mirror_of_lights_without_an_area():
    lamp = PointLight(position=(0, 0, 0.5), intensity=(1, 1, 1))
    for lights, mirrors in (((), True), ((lamp,), False)):
        glass = Glass(scene_of((FLOOR, PANE), (WIDE, BODY), lights=lights))
        assert glass.throws.tolist() == [mirrors, False]
        assert glass.mean_thrown[0].any() == mirrors
        np.testing.assert_allclose((glass.mean_passed + glass.mean_thrown)[0] < 0.9 - 1e-9, not mirrors)


def test_coloured_glass_dims_each_channel_by_itself():
    scene = scene_of((FLOOR, BLACK), (WIDE, RED))
    shares = [sky_share(scene, channel) for channel in range(3)]
    assert np.array(shares) / shares[0] == pytest.approx([1, 1 / 3, 0], abs=1e-6)
    assert Glass(scene).colours == [[0], [1], [2]]
    assert Glass(scene_of((FLOOR, PANE))).colours == [[0, 1, 2]]


@settings(SETTINGS, max_examples=40)
@given(st.lists(st.tuples(st.booleans(), *[st.sampled_from((0.0, 0.5, 0.8))] * 3), min_size=1, max_size=3))
def test_channels_are_followed_together_where_all_glass_and_all_mirrors_are_grey_in_them(parts):
    materials = [Material(name="part", **{"specular" if is_mirror else "transparent": shares})
                 for is_mirror, *shares in parts]
    scene = scene_of(*((np.add(FLOOR, (0, 0, height)), material) for height, material in enumerate(materials)))
    columns = list(zip(*(shares for _, *shares in parts), strict=True))
    groups = {tuple(other for other in range(3) if columns[other] == columns[channel]) for channel in range(3)}
    assert {tuple(group) for group in Glass(scene).colours} == groups


def test_what_does_not_pass_the_last_sheet_ends_there():
    clear = Material(name="clear", transparent=(1, 1, 1), refraction_index=1.0)
    panes = [(lifted(number), clear) for number in range(SHEETS + 1)]
    assert sky_share(scene_of((FLOOR, BLACK), *panes[:-1]), rays=(16, 4)) == 1
    assert sky_share(scene_of((FLOOR, BLACK), *panes), rays=(16, 4)) == 0


def room(*parts, diffuse=0.5):
    """A box under a white sky, closed but for what ``parts`` put over its front side, y = 0."""
    walls = box((0, 0, 0), (1, 1, 1))
    wall = Material(name="wall", diffuse=(diffuse,) * 3)
    behind = walls[walls[:, :, 1].max(axis=1) > 0]
    return scene_of((behind, wall, {"two_sided": True}), *parts, background=(1, 1, 1))


def seen(scene, **settings):
    camera = Camera(eye=(0.5, 0.5, 0.5), target=(0.5, 1, 0.4), up=(0, 0, 1), fov=60)
    return render(scene, camera=camera, settings=RenderSettings(**FEW | {"max_edge": 0.5} | settings)).image


def test_a_room_behind_a_pane_is_as_bright_as_the_pane_lets_pass():
    window = rectangle((0, 0, 0), (1, 0, 0), (0, 0, 1))
    bare = seen(room())
    tint = Material(name="tint", transparent=(0.8, 0.8, 0.8), refraction_index=1.0)
    np.testing.assert_allclose(seen(room((window, tint, {"two_sided": True}))), 0.8 * bare, rtol=2e-3)
    glazed = seen(room((window, PANE, {"two_sided": True})))
    assert 0.7 < (glazed / bare).min() <= (glazed / bare).max() < 0.87
    red = seen(room((window, RED, {"two_sided": True})))
    np.testing.assert_allclose(red[..., 0], glazed[..., 0], rtol=1e-12)
    assert (red[..., 1] < 0.4 * red[..., 0]).all()


@pytest.mark.parametrize("pane", [Material(name="pane", transparent=(1, 1, 1), thin=True), BODY],
                         ids=lambda material: material.name)
def test_a_white_room_behind_clear_glass_is_as_bright_as_the_sky(pane):
    """What does not pass is mirrored: nothing is lost, and the sky is all around."""
    window = rectangle((0, 0, 0), (1, 0, 0), (0, 0, 1))
    image = seen(room((window, pane, {"two_sided": True}), diffuse=1.0))
    np.testing.assert_allclose(image, 1, rtol=1e-5)


def test_a_glazed_room_has_the_same_bytes_for_any_jobs():
    scene = room((rectangle((0, 0, 0), (1, 0, 0), (0, 0, 1)), RED, {"two_sided": True}))
    one = seen(scene, jobs=1)
    np.testing.assert_array_equal(seen(scene, jobs=2), one)
    np.testing.assert_array_equal(seen(scene, method="naive"), one)


@pytest.mark.nightly
def test_a_glazed_room_is_alike_by_shelling():
    scene = room((rectangle((0, 0, 0), (1, 0, 0), (0, 0, 1)), RED, {"two_sided": True}))
    one = seen(scene)
    np.testing.assert_allclose(seen(scene, method="shelling").mean(axis=(0, 1)), one.mean(axis=(0, 1)), rtol=0.05)


def test_a_thin_pane_shows_what_is_behind_it_straight_and_mirrors_the_rest():
    behind = Material(name="behind", emission=(1, 1, 1))
    scene = scene_of((lifted(-10), PANE), (lifted(-20), behind), background=(0, 0, 0.5))
    angle = np.radians(60)
    camera = Camera(eye=(-np.sin(angle), 0, np.cos(angle)), target=(0, 0, 0), up=(0, 1, 0), fov=0.01)
    image = render(scene, camera=camera, settings=RenderSettings(**FEW | {"max_edge": 1e5})).image
    through, mirrored = 0.9 * sheet(0.5), 0.9 * (1 - sheet(0.5))
    np.testing.assert_allclose(image[2, 2], (through, through, through + 0.5 * mirrored), rtol=1e-3)


SILVER = Material(name="silver", diffuse=(0.1, 0.1, 0.1), specular=(0.8, 0.8, 0.4))
LAMP = Material(name="lamp", emission=(1, 2, 3))


def measured(scene, normal, **settings):
    """Irradiance over pi at the origin."""
    camera = Camera(eye=(0.5, 0, 0), target=(1, 0, 0), up=(0, 0, 1))
    sensors = Sensors(position=np.zeros((1, 3)), normal=np.array([normal], dtype=np.float64))
    return render(scene, camera=camera, sensors=sensors, settings=RenderSettings(
        **{"width": 2, "height": 1, "samples": 1, "max_edge": 2.0, "rays": (32, 8)} | settings)).sensors[0]


@pytest.mark.parametrize("two_sided", [False, True])
def test_a_flat_mirror_throws_the_light_of_the_lamp_behind_it(two_sided):
    """The lamp lies in the plane of the place and is seen in the mirror alone: its image shines (Lambert's formula)."""
    mirror = rectangle((2, -3, -3), (0, 0, 6), (0, 6, 0))
    lamp = rectangle((0, 0.5, -0.5), (0, 1, 0), (0, 0, 1))
    scene = scene_of((mirror, Material(name="mirror", specular=(0.8, 0.8, 0.4)), {"two_sided": two_sided}),
                     (lamp, LAMP))
    image = rectangle((4, 0.5, -0.5), (0, 0, 1), (0, 1, 0))
    factor = point_to_polygon([(0, 0, 0)], [(1, 0, 0)], [image])[0, 0]
    assert measured(scene, (1, 0, 0)) == pytest.approx(factor * np.array([0.8, 1.6, 1.2]), rel=5e-3)
    assert Glass(scene).colours == [[0, 1], [2]]


def test_the_back_of_a_one_sided_mirror_throws_nothing():
    mirror = rectangle((2, -3, -3), (0, 6, 0), (0, 0, 6))
    scene = scene_of((mirror, SILVER), (rectangle((0, 0.5, -0.5), (0, 1, 0), (0, 0, 1)), LAMP))
    assert not measured(scene, (1, 0, 0)).any()


@pytest.mark.parametrize("emission", [True, False], ids=["glowing", "under a sky"])
def test_a_furnace_with_a_mirror_is_as_bright_as_without(emission):
    """All surfaces reflect half of the light, one of them as a mirror: the radiance is the same everywhere."""
    glow = (1.0, 1.0, 1.0) if emission else (0.0, 0.0, 0.0)
    walls = box((-1, -1, -1), (1, 1, 1))[:, ::-1]
    wall, mirror = (Material(name=name, emission=glow, **{name: (0.5, 0.5, 0.5)}) for name in ("diffuse", "specular"))
    parts = ((walls[:4], wall), (walls[4:5], mirror)) + (((walls[5:], wall),) if emission else ())
    scene = scene_of(*parts, background=(0, 0, 0) if emission else (1, 1, 1))
    plain = scene_of((walls[:5], wall), *parts[2:], background=scene.background)
    with_mirror, without = (measured(one, (0, 0, 1), max_edge=0.5) for one in (scene, plain))
    if emission:
        assert with_mirror == pytest.approx(np.full(3, 2.0), rel=5e-3)
    # Facing the opening, the mirror behind the place throws nothing but what the walls reflect.
    assert with_mirror == pytest.approx(without, rel=0.02)


@pytest.mark.parametrize(("last", "share"), [
    ("diffuse", 0.6), *(("specular", share) for share in (0.6, 0.9, 0.99, 0.995, 1.0))])
def test_what_a_mirror_throws_of_a_point_light_diffuses(last, share):
    """Nothing is lost: the walls of a closed box absorb what the light emits."""
    walls = box((-1, -1, -1), (1, 1, 1))[:, ::-1]
    light = PointLight(position=(0, 0, 0.2), intensity=(1, 1, 1))
    scene = scene_of((walls[:5], Material(name="wall", diffuse=(0.6,) * 3)),
                     (walls[5:], Material(name="last", **{last: (share,) * 3})), lights=(light,))
    lit = solved(scene, 0.25)
    kept = np.where(lit.elements.patch < 5, 0.4, 1 - share)
    # The flux over pi, as of irradiances.
    assert (kept * lit.elements.area) @ lit.received[:, 0] == pytest.approx(4, rel=0.01)


@pytest.mark.parametrize("lights", [(), (PointLight(position=(0, 0, 0.5), intensity=(1, 1, 1)),)], ids=["sky", "point"])
@pytest.mark.parametrize("rest", [{}, {"diffuse": (0.1,) * 3, "specular": (0.2,) * 3}], ids=["clear", "mixed"])
@pytest.mark.parametrize("thin", [True, False], ids=["sheet", "body"])
def test_the_radiosity_of_glass_is_what_it_reflects_of_all_that_arrives(thin, rest, lights):
    """What it mirrors counts as diffuse, and what passes does not count."""
    glass = Material(name="glass", transparent=(0.7,) * 3, thin=thin, **rest)
    floor = rectangle((-1, -1, 0), (2, 0, 0), (0, 2, 0))
    lit = solved(scene_of((floor, glass), lights=lights, background=(1, 2, 4)), 1)
    passed, _ = quad(lambda cosine: 2 * cosine * (sheet(cosine) if thin else 1 - surface(cosine)), 1e-6, 1)
    share = 0.7 * (1 - passed) + (0.3 if rest else 0)
    assert (lit.received > 0).all()
    np.testing.assert_allclose(lit.radiosity, share * lit.received, rtol=1e-3)


@pytest.mark.parametrize("index", [1.33, 1.45, 1.5])
def test_sheets_reflect_no_share_below_zero_in_the_first_pass(index):
    """All that clear sheets do not absorb goes on; however it is rounded, nothing negative is left."""
    draw = np.random.default_rng(3)
    panes = [(np.add(FLOOR, (0, 0, number)), Material(name=f"{number}", transparent=(share,) * 3, thin=True,
                                               refraction_index=index))
             for number, share in enumerate(draw.random(60).tolist())]
    lit = solved(scene_of(*panes, background=(1, 1, 1)), 1)
    assert ((lit.reflectance >= 0) & (lit.reflectance < 1e-12)).all()
    assert (lit.display >= 0).all()


@pytest.mark.parametrize(("material", "smooth", "is_refused"), [
    (PANE, False, True), (BODY, True, True), (Material(name="half", specular=(0, 0.5, 0)), False, True),
    (Material(name="weak", specular=(0.49,) * 3), False, False),
    (Material(name="ball", specular=(1,) * 3), True, False),
], ids=lambda value: getattr(value, "name", None))
def test_shooting_is_refused_where_light_goes_on(material, smooth, is_refused):
    """A row is turned into a column by reciprocity, which holds if rays end where they meet a patch."""
    body = sphere((0, 0, 0), 0.5, segments=4) if smooth else rectangle((-1, -1, 0), (2, 0, 0), (0, 2, 0))
    scene = scene_of((body, material, {"smooth": smooth}), (rectangle((-1, -1, 2), (0, 2, 0), (2, 0, 0)), LAMP))
    camera, few = Camera(eye=(0, -4, 1), target=(0, 0, 0)), RenderSettings(**FEW, shooting=Shooting(tolerance=0.1))
    assert Glass(scene).goes_on.any() == is_refused
    with pytest.raises(InputError, match=material.name) if is_refused else nullcontext() as caught:
        render(scene, camera=camera, settings=few)
    assert not is_refused or caught.value.parameter == "shooting"
