"""Rays behind flat mirrors and panes, as screens: they meet what single rays in double precision meet."""

import weakref
from dataclasses import replace

import numpy as np
import pytest

from golden.cast.grid import Grid
from golden.cast.screen import Screen
from golden.engine.cast.fixed_frusta import NaiveFixedFrusta, ShellingFrusta
from golden.engine.cast.specular_frusta import specular_planes
from golden.scene.builtin.shapes import box
from golden.scene.camera import Camera
from golden.scene.material import Material
from tb.golden.cast.mirrors import CAMERA, MIRROR, PARTS, mirror_room, rays_behind
from tb.golden.light.scenes import BLACK, rectangle, scene_of

SIZE = 160, 100


def screen_of(camera=CAMERA, size=SIZE):
    return Screen(camera=camera, width=size[0], height=size[1])


def planes_of(scene, screen):
    patch = Grid(scene, 0.25).nearest(screen.rays()).patch
    return [*specular_planes(scene, np.array(screen.camera.eye), patch)]


@pytest.mark.parametrize("caster", [NaiveFixedFrusta, ShellingFrusta])
@pytest.mark.parametrize("is_mirrored", [True, False])
def test_rays_meet_what_single_rays_meet(caster, is_mirrored):
    scene = mirror_room()
    rays, field = rays_behind(scene, CAMERA, SIZE, is_mirrored=is_mirrored)
    specular = caster(scene).specular(screen_of(), 1)
    # In any parts and order.
    some = np.random.default_rng(1).permutation(len(rays))
    parts = [(part, *specular.nearest(rays[part], field[part], is_mirrored=is_mirrored))
             for part in (some[:100], some[:0], some[100:])]
    rows = np.concatenate([part[found] for part, found, _ in parts])
    expected = Grid(scene, 0.25).nearest(rays)
    # Left to others are rays for which a board is before the mirror; through the pane the eye sees it itself.
    left = len(rays) - len(rows)
    assert 0.005 * len(rays) < left < 0.1 * len(rays) if is_mirrored else left == 0
    assert specular.rays == len(rows) > 400
    patch = np.concatenate([hits.patch for _, _, hits in parts])
    same = patch == expected.patch[rows]
    assert same.mean() > 0.995
    assert len(np.unique(patch)) >= 4
    for name in "t", "u", "v":
        found = np.concatenate([getattr(hits, name) for _, _, hits in parts])
        np.testing.assert_allclose(found[same], getattr(expected, name)[rows][same], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("caster", [NaiveFixedFrusta, ShellingFrusta])
def test_some_rays_of_a_screen_have_its_hits(caster):
    """Among patches of their own, in coordinates that hold their eye."""
    scene, number = mirror_room(), np.array([517, 33, 400, 34])
    most = np.arange(len(scene))
    for patches, eye in (most, CAMERA.eye), (most[2:], CAMERA.eye), (most, (30.0, 1.0, 2.0)), (most, (0.0, 40.0, 1.0)):
        screen = screen_of(replace(CAMERA, eye=eye), (30, 20))
        whole, _, _ = NaiveFixedFrusta(scene).beyond(patches, screen, np.arange(len(screen)))
        found, tests, _ = caster(scene).beyond(patches, screen, number)
        np.testing.assert_array_equal(found, whole[number])
        assert (tests[found >= 0] > 0).all()


@pytest.mark.parametrize("is_mirrored", [True, False])
def test_screens_have_the_directions_and_the_patches_of_their_rays(is_mirrored):
    scene = mirror_room()
    rays, field = rays_behind(scene, CAMERA, SIZE, is_mirrored=is_mirrored)
    (plane,) = (one for one in planes_of(scene, screen_of()) if one.fields[0] == field[0])
    np.testing.assert_array_equal(plane.fields, field)
    screen, number = plane.screen(screen_of(), is_mirrored=is_mirrored)
    through = screen.rays(number)
    assert np.abs(np.cross(through.direction, rays.direction)).max() < 1e-9
    # They pass through the points from which the rays go on.
    depth = np.einsum("kj,kj->k", rays.origin - through.origin, through.direction) / np.einsum(
        "kj,kj->k", through.direction, through.direction)
    np.testing.assert_allclose(through.origin + depth[:, None] * through.direction, rays.origin, atol=1e-9)
    normal = scene.normals[plane.own[0]]
    away = (scene.vertices - rays.origin[0]) @ (normal * np.sign(normal @ rays.direction[0]))
    np.testing.assert_array_equal(plane.beyond(is_mirrored=is_mirrored), np.flatnonzero(away.max(axis=1) > 1e-6))


def test_planes_that_few_rays_meet_are_left_to_others():
    scene, screen = mirror_room(), screen_of()
    mirror = int(np.flatnonzero(scene.channels("specular").any(axis=1))[0])
    patch = np.full(len(screen), mirror)
    for enough in 256, 255:
        patch[enough:] = -1
        found = [*specular_planes(scene, np.array(CAMERA.eye), patch)]
        assert [one.fields.tolist() for one in found] == [[*range(256)]] * (enough == 256)


def tiled_mirror(*, rise=0.0, are_pairs=False, tiles=8):
    """A turned mirror of tiles before two walls, in float32 as files have it. Half of the tiles may be moved; each may
    be two back to back.
    """
    turned = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    side = np.arange(tiles) / tiles
    quads = np.array([rectangle((x, y, 0), (1 / tiles, 0, 0), (0, 1 / tiles, 0)) for x in side for y in side])
    quads[::2, :, 2] += rise
    back = np.array([rectangle((-1, -1, 1.5), (0, 3, 0), (3, 0, 0)), rectangle((-1, -1, -0.3), (0.9, 0, 0), (0, 3, 2))])
    if are_pairs:
        quads = np.concatenate([quads, quads[:, ::-1]])
    parts = (quads, MIRROR, not are_pairs), (back, BLACK, True)
    scene = scene_of(*((np.float32(part @ turned), material, {"two_sided": sides}) for part, material, sides in parts))
    eye, target = np.array([(0.4, 0.6, 1.2), (0.5, 0.5, 0)]) @ turned
    return scene, Camera(eye=eye, target=target, up=turned[0], fov=60)


@pytest.mark.parametrize("are_pairs", [False, True])
def test_mirrors_of_float32_are_one_plane(are_pairs):
    """Each tile is planar, and in the plane of all, to the rounding of its corners; hits are those of single rays."""
    scene, camera = tiled_mirror(are_pairs=are_pairs)
    rays, field = rays_behind(scene, camera, SIZE, is_mirrored=True)
    off = (scene.vertices[:64] - scene.centres[:64].mean(axis=0)) @ scene.normals[0]
    assert np.abs(off).max() > 2.0**-26
    specular = ShellingFrusta(scene).specular(screen_of(camera), 1)
    rows, hits = specular.nearest(rays, field, is_mirrored=True)
    expected = Grid(scene, 0.25).nearest(rays)
    same = hits.patch == expected.patch[rows]
    assert len(np.unique(rays.source)) == 64
    assert len(rows) > 0.99 * len(rays) > 5000
    assert same.mean() > 0.998
    np.testing.assert_allclose(hits.t[same], expected.t[rows][same], rtol=1e-6)


def test_one_plane_reflects_and_passes():
    scene = mirror_room(mirror=Material(name="half", specular=(0.5,) * 3, transparent=(0.4,) * 3, thin=True))
    specular = NaiveFixedFrusta(scene).specular(screen_of(), 1)
    for is_mirrored in True, False:
        rays, field = rays_behind(scene, CAMERA, SIZE, is_mirrored=is_mirrored)
        rows, hits = specular.nearest(rays, field, is_mirrored=is_mirrored)
        assert len(rows) > 400
        assert (hits.patch == Grid(scene, 0.25).nearest(rays).patch[rows]).mean() > 0.995


def test_the_six_walls_of_a_cube_are_six_planes():
    """All are as far from its middle."""
    scene = scene_of((box((0, 0, 0), (1, 1, 1)), MIRROR, {"two_sided": True}))
    planes = [*specular_planes(scene, np.array((0.3, 0.4, 0.6)), np.repeat(np.arange(6), 256))]
    assert sorted(one.own.tolist() for one in planes) == [[0], [1], [2], [3], [4], [5]]
    assert all((one.fields // 256 == one.own).all() for one in planes)


def test_a_mirror_with_nothing_beyond_shows_nothing():
    scene = scene_of((PARTS["mirror"], MIRROR))
    rays, field = rays_behind(scene, CAMERA, SIZE, is_mirrored=True)
    rows, hits = ShellingFrusta(scene).specular(screen_of(), 1).nearest(rays, field, is_mirrored=True)
    assert len(rows) == len(rays) > 256
    assert (hits.patch == -1).all()


def test_a_second_screen_has_patches_of_its_own():
    frusta, scene = NaiveFixedFrusta(mirror_room()), mirror_room()
    for eye in CAMERA.eye, (-0.5, -2.0, 1.0), CAMERA.eye:
        screen = screen_of(replace(CAMERA, eye=eye))
        assert (frusta.patches(screen) == Grid(scene, 0.25).nearest(screen.rays()).patch).mean() > 0.995


def test_planes_that_are_near_each_other_are_two():
    """Farther apart than rounding moves corners, also where all rays meet patches of the same normal."""
    for rise, count in (2e-4, 2), (0, 1):
        scene, camera = tiled_mirror(rise=rise)
        assert len(planes_of(scene, screen_of(camera))) == count


def warped_pane(warp, **more):
    room, away = mirror_room(**more), np.array([0, warp, 0])
    vertices = room.vertices.copy()
    vertices[(room.vertices[:, 0] == PARTS["pane"][0]).all(axis=1), 1:] += [away, -away, away]
    return replace(room, vertices=vertices)


def test_panes_of_rounded_corners_do_not_show_themselves():
    """No quadrilateral of a file in float32 is planar: a corner of its own is beyond the plane that rays leave."""
    scene = warped_pane(2e-7)
    rays, field = rays_behind(scene, CAMERA, SIZE, is_mirrored=False)
    rows, hits = ShellingFrusta(scene).specular(screen_of(), 1).nearest(rays, field, is_mirrored=False)
    assert len(rows) >= 256
    assert (scene.surface[hits.patch] != rays.source[rows]).all()


@pytest.mark.parametrize(("warp", "gap"), [(0, 1e-7), (2e-7, -1e-7)])
def test_films_on_panes_are_left_to_others(warp, gap):
    """Nearer behind a pane than float32 keeps its corners, or through one whose corners are not in a plane."""
    scene, size = warped_pane(warp, more=[(PARTS["pane"] + (0, gap, 0), BLACK, {"two_sided": True})]), (320, 200)
    rays, field = rays_behind(scene, CAMERA, size, is_mirrored=False)
    film = Grid(scene, 0.25).nearest(rays).patch == len(scene) - 1
    assert film.sum() >= 256
    rows, _ = ShellingFrusta(scene).specular(screen_of(size=size), 1).nearest(rays, field, is_mirrored=False)
    assert not film[rows].any()


def test_each_plane_is_cast_once_and_its_tables_are_not_kept(monkeypatch):
    scene, made = mirror_room(), []
    original = NaiveFixedFrusta._some

    def some(caster, geometry):
        made.append(weakref.ref(geometry))
        return original(caster, geometry)

    frusta = NaiveFixedFrusta(scene)
    specular = frusta.specular(screen_of(), 1)
    monkeypatch.setattr(NaiveFixedFrusta, "_some", some)
    for is_mirrored in (True, False):
        rays, field = rays_behind(scene, CAMERA, SIZE, is_mirrored=is_mirrored)
        for part in np.array_split(np.arange(len(rays)), 4):
            specular.nearest(rays[part], field[part], is_mirrored=is_mirrored)
    assert [one() for one in made] == [None, None]
