"""The largest patches are halved until there are enough; halves stay in the place of their patch."""

import numpy as np
import pytest
from hypothesis import given, settings

from golden.base.errors import InputError
from golden.scene.builtin import builtin_scene
from golden.scene.halve import MOST_PATCHES, halved
from tb.golden.light.drawn_scenes import unequal_scenes
from tb.golden.light.scenes import BLACK, rectangle, scene_of
from tb.lib.schedules import SETTINGS


@pytest.mark.parametrize("patches", [20, 21, 100, 333])
def test_area_and_surfaces_stay(patches):
    scene = builtin_scene("cornell")
    found = halved(scene, patches)
    assert len(found) == patches
    assert np.allclose(np.bincount(found.surface, found.areas), np.bincount(scene.surface, scene.areas), rtol=1e-12)
    assert (np.diff(found.surface) >= 0).all()
    assert np.array_equal(np.unique(found.material), np.unique(scene.material))
    assert np.allclose(found.normals, scene.normals[np.searchsorted(scene.surface, found.surface)])


def test_the_largest_patch_is_cut_across_its_longest_side():
    scene = scene_of((rectangle((0, 0, 0), (4, 0, 0), (0, 1, 0)), BLACK),
                     (rectangle((0, 0, 1), (1, 0, 0), (0, 3, 0)), BLACK))
    found = halved(scene, 4)
    assert np.allclose(found.areas, [2, 2, 1.5, 1.5])
    assert found.vertices[0].tolist() == [[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]]
    assert found.vertices[3].tolist() == [[0, 1.5, 1], [1, 1.5, 1], [1, 3, 1], [0, 3, 1]]
    assert found.surface.tolist() == [0, 0, 1, 1]


@settings(SETTINGS, max_examples=60)
@given(unequal_scenes())
def test_quads_are_cut_across_their_longer_pair_of_sides_and_triangles_across_the_longest(scene):
    found = halved(scene, len(scene) + 1)
    cut = int(np.argmax(scene.areas))
    corners = scene.vertices[cut, :3 if scene.is_triangle[cut] else 4]
    lengths = np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1)
    middles = (np.roll(corners, -1, axis=0) + corners) / 2
    if len(corners) == 3:
        chosen = middles[lengths >= lengths.max() - 1e-12]
    else:
        sums = lengths + np.roll(lengths, 2)
        chosen = middles[sums >= sums.max() - 1e-12]
    old = {tuple(corner) for corner in corners.tolist()}
    halves = [part for part in found.vertices.tolist() if part[0][2] == corners[0, 2]]
    new = {tuple(corner) for part in halves for corner in part} - old
    assert len(halves) == 2
    assert len(new) == (1 if len(corners) == 3 else 2)
    assert new <= {tuple(middle) for middle in chosen.tolist()}


def test_parts_of_a_strip_stay_in_its_order():
    """Whatever their generations are."""
    for patches in range(2, 20):
        left = halved(scene_of((rectangle((0, 0, 0), (64, 0, 0), (0, 1, 0)), BLACK)), patches).vertices[:, 0, 0]
        assert (np.diff(left) > 0).all(), patches


def test_halves_of_a_triangle_are_triangles():
    triangle = np.array([(0, 0, 0), (4, 0, 0), (0, 3, 0), (0, 3, 0.0)])
    found = halved(scene_of((triangle, BLACK)), 3)
    assert found.is_triangle.all()
    assert np.isclose(found.areas.sum(), 6)
    assert np.allclose(found.normals, (0, 0, 1))
    assert np.allclose(np.sort(found.areas), (1.5, 1.5, 3))


@pytest.mark.parametrize(("patches", "error", "message"), [
    (19, InputError, f"scene 'cornell': Patches must be 20 to {MOST_PATCHES}, not 19"),
    (MOST_PATCHES + 1, InputError, "Patches must be 20 to"), (20.0, TypeError, "Patches must be an int, not 20.0")])
def test_numbers_out_of_range_are_refused(patches, error, message):
    with pytest.raises(error, match=message):
        halved(builtin_scene("cornell"), patches)
