from collections import Counter

import numpy as np
import pytest

from golden.scene.builtin import builtin_scene
from golden.scene.builtin.city import CELL, STOREY
from tb.golden.scene.closed import assert_good_patches


@pytest.fixture(scope="module")
def scene():
    return builtin_scene("city")


def test_the_default_has_22_thousand_facets(scene):
    assert len(scene) == 22058
    assert not scene.two_sided.any()


def test_facets_are_small(scene):
    assert_good_patches(scene.vertices, scene.size)
    assert scene.areas.max() < 4 * CELL * STOREY


def test_neighbours_share_whole_edges_and_only_the_border_is_open(scene):
    _, corner = np.unique(scene.vertices.reshape(-1, 3), axis=0, return_inverse=True)
    start = corner.reshape(-1, 4)
    end = np.roll(start, -1, axis=1)
    edges = Counter(zip(start[start != end].tolist(), end[start != end].tolist(), strict=True))
    assert set(edges.values()) == {1}
    points = np.empty((corner.max() + 1, 3))
    points[corner] = scene.vertices.reshape(-1, 3)
    single = points[[edge for edge in edges if edge[::-1] not in edges]]
    assert (single[..., 2] == 0).all()
    width = scene.bounds[1, 0]
    assert len(single) == 4 * width / CELL
    assert (np.isin(single[..., :2], (0, width)).any(axis=2)).all()


def test_it_has_streets_courtyards_towers_and_churches(scene):
    names = np.array([material.name for material in scene.materials])[scene.material]
    ground = scene.vertices[:, :, 2].max(axis=1) == 0
    assert {"asphalt", "pavement", "lawn"} <= set(names[ground])
    assert {"roof tiles", "flat roof", "slate", "glass front", "sandstone"} <= set(names[~ground])
    assert (scene.normals[ground] == (0, 0, 1)).all()
    assert scene.bounds[1, 2] > 20 * STOREY


@pytest.mark.parametrize("size", [1, 2])
def test_smaller_cities_have_fewer_plots(size):
    small = builtin_scene(f"city:{size}")
    assert small.bounds[1, 0] == (14 * size + 4) * CELL
