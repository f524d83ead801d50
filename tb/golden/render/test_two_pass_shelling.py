from dataclasses import replace

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.density import Density
from golden.cast.frame import frame
from golden.cast.grid import Grid
from golden.cast.hemisphere import Hemisphere
from golden.cast.rays import Rays
from golden.cast.screen import Screen
from golden.cast.shadow_rays import ShadowHits
from golden.engine.cast.fixed_frusta import CELL, CONFIG, FixedFrusta, NaiveFixedFrusta, ShellingFrusta
from golden.engine.cast.shelling import Shelling
from golden.engine.frustum import hemisphere_record, screen_record
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.light import in_flight
from golden.light.form_factors import PatchRows, hemisphere_sums
from golden.render.two_pass import RenderSettings, render
from golden.scene.builtin import builtin_scene
from golden.scene.camera import Camera
from golden.scene.lights import PointLight
from golden.scene.material import Material
from golden.scene.tessellate import sphere
from tb.golden.cast.mirrors import CAMERA, MIRROR, mirror_room
from tb.golden.light.cube import cube
from tb.golden.light.scenes import rectangle, scene_of

LAMP = Material(name="lamp", emission=(4.0, 2.0, 1.0))
SIZE, SPREAD = 32, 2.0**-13
FIELDS = ("patch", "t", "u", "v")


@pytest.fixture(scope="module")
def cornell():
    return builtin_scene("cornell")


def picture(scene, method, frusta=None, **settings):
    chosen = {"width": SIZE, "height": SIZE, "samples": 1, "light_samples": 4, "rays": (64, 16), "max_edge": 160.0}
    return render(scene, camera=scene.camera, frusta=frusta,
                  settings=RenderSettings(**(chosen | settings), method=method))


def primary(caster, camera, size=SIZE):
    screen = Screen(camera=camera, width=size, height=size)
    number = np.arange(len(screen))
    return caster.screen(screen, 1)(np.zeros(len(screen), dtype=int), number, screen.rays())


def hemisphere_hits(caster, points, normals, surfaces, rays=(32, 8)):
    hemisphere, frames = Hemisphere(*rays), frame(normals)
    sample, ray = np.divmod(np.arange(len(points) * len(hemisphere)), len(hemisphere))
    direction = np.einsum("rk,rki->ri", hemisphere.directions[ray], frames[sample])
    return caster.hemispheres(hemisphere, points, frames, surfaces)(
        sample, ray, Rays(points[sample], direction, surfaces[sample]))


def around(screen, pixels):
    """Eight rays in a narrow cone around the ray of each pixel."""
    angle = np.arange(8) * np.pi / 4
    ring = SPREAD / screen.pitch * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return screen.rays(np.repeat(pixels, 8), np.tile(ring, (len(pixels), 1)))


@pytest.mark.parametrize("name", ["cornell", "room1627"])
def test_pixels_show_the_patch_that_grid_shows_or_one_that_rounding_reaches(name):
    scene = builtin_scene(name)
    screen = Screen(camera=scene.camera, width=SIZE, height=SIZE)
    grid = Grid(scene, 0.125)
    ours, theirs = primary(ShellingFrusta(scene), scene.camera), primary(grid, scene.camera)
    other = np.flatnonzero(ours.patch != theirs.patch)
    assert len(other) <= 0.002 * len(screen)
    near = grid.nearest(around(screen, other)).patch.reshape(-1, 8)
    assert (near == ours.patch[other, None]).any(axis=1).all()
    same = (ours.patch == theirs.patch) & (theirs.patch >= 0)
    for field in ("t", "u", "v"):
        np.testing.assert_allclose(getattr(ours, field)[same], getattr(theirs, field)[same], rtol=1e-9, atol=1e-9)


class GridToSharedPoints(Grid):
    """In double precision, to the points of lights and through the points of pixels that frusta have."""

    regular = True

    def shadows(self, rays):
        surfaces = np.stack([rays.surfaces[rays.light], np.full(len(rays), -1)], axis=1)
        # A ray ends in front of its shaded point.
        targets = rays.targets + 2.0**-20 * (rays.points[rays.light] - rays.targets)
        none = np.zeros(len(rays), dtype=int)
        return ShadowHits(cast=np.full(len(rays), True), tests=none, steps=none,
                          blocked=self.occluded(rays.points[rays.light], targets, surfaces))


def test_the_image_is_that_of_grid_through_the_same_points(cornell, monkeypatch):
    monkeypatch.setattr("golden.light.indirect.EVERY", 10**9)  # no elements are cut
    grid, shelling = (picture(cornell, method, frusta, max_edge=600.0, light_samples=16).image for method, frusta in (
        ("grid", GridToSharedPoints(cornell, 0.125)), ("shelling", None)))
    hits = [primary(caster, cornell.camera).patch for caster in (Grid(cornell, 0.125), ShellingFrusta(cornell))]
    same = (hits[0] == hits[1]).reshape(SIZE, SIZE)
    assert same.mean() > 0.998
    np.testing.assert_allclose(shelling[same], grid[same], rtol=2e-3, atol=1e-4 * grid.mean())


@pytest.mark.parametrize(("together", "records"), [(0, [1] * 6), (256, [1] * 6), (1023, [3, 3]), (1 << 20, [6])])
def test_frusta_that_are_cast_together_have_their_own_hits(cornell, together, records):
    """A caster may cast those that follow the one requested."""
    points, surfaces, counts = cornell.vertices[:6].mean(axis=1), cornell.surface[:6], []

    class Together(ShellingFrusta):
        def _machine(self, geometry):
            cast = super()._machine(geometry)

            def counted(given):
                counts.append(len(given))
                return cast(given)
            return counted

    caster = Together(cornell)
    caster.together = together
    ours, each = (hemisphere_hits(one, points, cornell.normals[:6], surfaces)
                  for one in (caster, ShellingFrusta(cornell)))
    for field in (*FIELDS, "tests", "steps"):
        np.testing.assert_array_equal(getattr(ours, field), getattr(each, field))
    assert counts == records


def test_form_factors_are_those_of_grid_but_for_rays_on_edges(cornell):
    grid, shelling = (PatchRows(cornell, caster, rays=(128, 32)).rows(np.arange(len(cornell))).toarray()
                      for caster in (Grid(cornell, 0.125), ShellingFrusta(cornell)))
    assert np.abs(shelling - grid).max() < 2e-3
    assert np.abs(shelling - grid).sum(axis=1).mean() < 1e-3


@pytest.mark.parametrize(("scene", "rays"), [(builtin_scene("furnace:2"), (64, 16)), (cube(2), (2048, 4))],
                         ids=["furnace", "cube"])
def test_a_hemisphere_in_a_closed_scene_sums_to_one_exactly(scene, rays):
    some = np.arange(0, len(scene), 9)
    factors, row_sums, _ = PatchRows(scene, ShellingFrusta(scene), rays=rays, samples=2).cast(some)
    assert (row_sums == 2**(40 if rays[0] >= 2048 else 32)).all()
    np.testing.assert_allclose(factors.sum(axis=1), 1, rtol=1e-12)
    assert factors[np.arange(len(some)), some].max() == 0


def test_nodes_in_the_corners_of_a_closed_room_lose_no_ray():
    """A strip that is 2500 times lower than the room runs along its wall: its nodes stand close to the floor."""
    strip = rectangle((0.2, 1e-3, 0), (0.6, 0, 0), (0, 0, 4e-4))
    walls = cube(1).vertices
    scene = scene_of((walls[:5], Material(name="grey", diffuse=(0.5, 0.5, 0.5))), (walls[5:], LAMP),
                     (strip, Material(name="dark")), camera=Camera(eye=(0.5, 0.5, 0.5), target=(0.5, 1, 0.4),
                                                                   up=(0, 0, 1), fov=60))
    stats = picture(scene, "shelling", width=4, height=4, rays=(16, 4), max_edge=1.0).stats["rays"]["hemisphere"]
    assert stats["hits"] == stats["rays"]


def test_tests_and_steps_are_those_that_shelling_counts(cornell):
    shelling, geometry = ShellingFrusta(cornell), PatchGeometry.of(cornell, CONFIG.numbers)
    machine = Shelling(geometry, CONFIG, cell=CELL)
    screen = screen_record(Screen(camera=cornell.camera, width=SIZE, height=SIZE), geometry.coordinates)
    point, normal, surface = cornell.vertices[:1].mean(axis=1), cornell.normals[:1], cornell.surface[:1]
    hemisphere = hemisphere_record(Hemisphere(32, 8), geometry.coordinates, point[0], normal[0],
                                   source=int(surface[0]), axes=frame(normal[0]))
    for record, hits in ((screen, primary(shelling, cornell.camera)),
                         (hemisphere, hemisphere_hits(shelling, point, normal, surface))):
        fixed, (counts,) = machine.cast(record)
        np.testing.assert_array_equal(hits.patch, fixed.patch)
        assert (hits.tests.sum(), hits.steps.sum()) == (counts.tests, counts.cell_steps)
        assert counts.cell_steps > 0


def test_stats_and_heat_maps_hold_all_of_the_work(cornell, monkeypatch):
    monkeypatch.setattr("golden.light.indirect.EVERY", 10**9)  # no elements are cut
    result, naive = (picture(cornell, method, width=8, height=8, rays=(16, 4), max_edge=600.0)
                     for method in ("shelling", "naive-fixed"))
    rays = result.stats["rays"]
    assert result.stats["settings"]["method"] == "shelling"
    assert rays["hemisphere"]["rays"] == result.stats["nodes"] * 64
    assert rays["primary"]["rays"] == 64
    for count, heat in (("tests", result.tests), ("steps", result.steps)):
        assert heat.sum() == sum(rays[kind][count] for kind in ("primary", "reflection", "refraction"))
        assert min(rays[kind][count] for kind in ("hemisphere", "primary", "shadow")) > 0
    assert rays["primary"]["tests"] < naive.stats["rays"]["primary"]["tests"] == 64 * len(cornell)
    assert result.image.tobytes() == naive.image.tobytes()


def test_samples_are_the_pixels_of_a_finer_image():
    panel = rectangle((-0.3, -0.2, 1), (0.8, 0.1, 0), (-0.1, 0.6, 0))
    camera = Camera(eye=(0, 0, 0), target=(0, 0, 1), up=(0, 1, 0), fov=60)
    scene = scene_of((panel[::-1], LAMP), camera=camera)
    coarse = picture(scene, "shelling", width=10, height=6, samples=9, max_edge=9.0, rays=(4, 4)).image
    fine = picture(scene, "shelling", width=30, height=18, max_edge=9.0, rays=(4, 4)).image
    np.testing.assert_allclose(coarse, fine.reshape(6, 3, 10, 3, 3).mean(axis=(1, 3)), rtol=1e-12)
    assert len(np.unique(coarse[..., 0])) > 3


def test_frusta_may_start_outside_of_the_scene(cornell):
    eye = np.array(cornell.camera.eye)
    away = Camera(eye=tuple(eye + 4 * (eye - cornell.bounds.mean(axis=0))), target=tuple(cornell.bounds.mean(axis=0)),
                  up=(0, 1, 0), fov=10)
    ours, theirs = (primary(caster, away).patch for caster in (ShellingFrusta(cornell), Grid(cornell, 0.125)))
    assert (ours >= 0).mean() > 0.2
    assert (ours != theirs).mean() < 0.01
    point, normal = np.array([away.eye]), cornell.normals[:1]
    hits = [hemisphere_hits(caster, point, normal, np.array([-1]))
            for caster in (ShellingFrusta(cornell), Grid(cornell, 0.125))]
    assert (hits[0].patch != hits[1].patch).mean() < 0.01


@pytest.mark.parametrize(("bad", "message"), [
    ({"cell": 2.0}, "Cell size must be 1/256 to 1 of the scene's longest side, not 2.0"),
    ({"rays": (4096, 2048)}, "frustum: Rays must be at most icu.rays (4194304), not 8388608"),
])
def test_frusta_that_the_machine_does_not_cast_are_refused(cornell, bad, message):
    with pytest.raises(InputError) as error:
        picture(cornell, "shelling", **bad)
    assert str(error.value) == message


def test_nodes_cast_finer_rays_around_small_patches(cornell):
    """Each has the factors of its hemisphere with finer rays, and all of them are counted."""
    made = picture(cornell, "shelling", width=2, height=2, depth=0, light_samples=1, rays=(16, 4), max_edge=600.0,
                   least_rays=6)
    nodes, pieces = made.indirect.elements.lattice.nodes, made.indirect.pieces
    sums = hemisphere_sums(NaiveFixedFrusta(cornell), Hemisphere(16, 4), *nodes, columns=len(pieces),
                           column_of=pieces.seen, density=Density(least=6))
    (factors,) = made.indirect.rows.cast(*nodes, Hemisphere(16, 4)).factors
    np.testing.assert_array_equal(factors.toarray(), sums.weights.toarray() * 2.0**-sums.weight_bits)
    # What adaptive refinement adds comes on top, and the second cast here.
    assert made.stats["rays"]["hemisphere"]["rays"] >= sums.rays.sum() > len(sums.rays) * 64


def test_finer_rays_need_a_method_of_frusta():
    with pytest.raises(InputError, match="Least rays need a method of frusta alone"):
        RenderSettings(method="grid", least_rays=4)
    with pytest.raises(InputError, match="Least must be 1 to 4096, not 0"):
        RenderSettings(method="shelling", least_rays=0)


def test_mirrors_and_panes_show_what_single_rays_see(monkeypatch):
    """Beside a ball that is a mirror, and to and fro between two mirrors, in batches of any size; but at borders of
    patches, which a frustum's rays may round to the other side of.
    """
    ball = sphere((0.1, -0.4, 0.6), 0.5, segments=8), MIRROR, {"smooth": True}
    second = rectangle((-1.9, -3.9, 0.1), (3.8, 0.3, 0), (0, 0, 2.8)), MIRROR, {"two_sided": True}
    scene = mirror_room(Material(name="wall", diffuse=(0.5, 0.6, 0.7)),
                        boards=Material(name="glass", transparent=(0.8, 0.8, 0.8), refraction_index=1.5),
                        more=(ball, second),
                        lights=(PointLight(position=(0.2, -1, 2.8), intensity=(9, 9, 9)),))
    settings = RenderSettings(width=80, height=50, samples=4, rays=(16, 4), max_edge=1.5, depth=4, method="naive-fixed")
    made = render(scene, camera=CAMERA, settings=settings, frusta=NaiveFixedFrusta(scene))
    monkeypatch.setattr(in_flight, "PRIMARY_BYTES", 1 << 15)
    parts = render(scene, camera=CAMERA, settings=replace(settings, memory=64), frusta=NaiveFixedFrusta(scene))
    np.testing.assert_allclose(parts.image, made.image, rtol=1e-12)
    monkeypatch.delattr(FixedFrusta, "specular")
    alone = render(scene, camera=CAMERA, settings=settings, frusta=NaiveFixedFrusta(scene))
    for kind in "reflection", "refraction":
        assert made.stats["rays"][kind]["rays"] == alone.stats["rays"][kind]["rays"] > 700
        # Brute force tests all patches of a screen with each ray.
        assert made.stats["rays"][kind]["tests"] > alone.stats["rays"][kind]["tests"]
    other = ~np.isclose(made.image, alone.image, rtol=1e-6, atol=1e-9).all(axis=2)
    assert other.mean() < 0.002
