"""Rays behind flat mirrors and panes, as screens: they meet what single rays in double precision meet."""

import numpy as np
import pytest

from golden.cast.grid import Grid
from golden.cast.screen import Screen
from golden.engine.cast.fixed_frusta import NaiveFixedFrusta, ShellingFrusta
from golden.engine.cast.specular_frusta import specular_screens
from tb.golden.cast.mirrors import CAMERA, mirror_room, rays_behind

SIZE = 160, 100


@pytest.mark.parametrize("caster", [NaiveFixedFrusta, ShellingFrusta])
@pytest.mark.parametrize("is_mirrored", [True, False])
def test_rays_meet_what_single_rays_meet(caster, is_mirrored):
    scene = mirror_room()
    rays, field, normal = rays_behind(scene, CAMERA, SIZE, is_mirrored=is_mirrored)
    specular = caster(scene).specular(Screen(camera=CAMERA, width=SIZE[0], height=SIZE[1]), 1)
    rows, hits = specular.nearest(rays, field, normal, is_mirrored=is_mirrored)
    expected = Grid(scene, 0.25).nearest(rays)
    # Left to others are rays for which a board is before the mirror; through the pane the eye sees it itself.
    left = len(rays) - len(rows)
    assert 0.005 * len(rays) < left < 0.1 * len(rays) if is_mirrored else left == 0
    assert specular.rays == len(rows) > 400
    same = hits.patch == expected.patch[rows]
    assert same.mean() > 0.995
    assert len(np.unique(hits.patch)) >= 4
    for name in "t", "u", "v":
        np.testing.assert_allclose(getattr(hits, name)[same], getattr(expected, name)[rows][same], rtol=1e-6, atol=1e-6)


def test_screens_have_the_directions_and_the_patches_of_their_rays():
    scene, screen = mirror_room(), Screen(camera=CAMERA, width=SIZE[0], height=SIZE[1])
    for is_mirrored in (True, False):
        rays, field, normal = rays_behind(scene, CAMERA, SIZE, is_mirrored=is_mirrored)
        (one,) = specular_screens(scene.vertices, screen, field, rays.origin, normal, is_mirrored=is_mirrored)
        through = one.screen.rays(one.number)
        away = np.cross(through.direction, rays.direction[one.rows])
        assert np.abs(away).max() < 1e-9
        # They pass through the points from which the rays go on.
        depth = np.einsum("kj,kj->k", rays.origin[one.rows] - through.origin, through.direction) / np.einsum(
            "kj,kj->k", through.direction, through.direction)
        place = through.origin + depth[:, None] * through.direction
        np.testing.assert_allclose(place, rays.origin[one.rows], atol=1e-9)
        beyond = np.einsum("nvj,j->nv", scene.vertices - rays.origin[0], normal[0]).max(axis=1) > 1e-6
        np.testing.assert_array_equal(one.patches, np.flatnonzero(beyond))


def test_planes_that_few_rays_meet_are_left_to_others():
    scene, screen = mirror_room(), Screen(camera=CAMERA, width=SIZE[0], height=SIZE[1])
    rays, field, normal = rays_behind(scene, CAMERA, SIZE, is_mirrored=True)
    # Half of the rays meet another plane, by a tenth of a millionth of the room.
    moved = rays.origin + np.where(np.arange(len(rays)) % 2, 4e-7, 0)[:, None] * normal
    found = [*specular_screens(scene.vertices, screen, field, moved, normal, is_mirrored=True)]
    assert sorted(len(one.rows) for one in found) == [len(rays) // 2, -(-len(rays) // 2)]
    assert not [*specular_screens(scene.vertices, screen, field[:255], rays.origin[:255], normal[:255],
                                  is_mirrored=True)]
