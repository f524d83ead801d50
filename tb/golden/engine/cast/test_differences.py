from dataclasses import replace

import numpy as np
import pytest

from golden.cast.naive import Naive
from golden.engine.cast.differences import differences, oracle_rays
from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.cast.naive_fixed import NaiveFixed
from tb.golden.cast.fixed_cases import WHERE, long_edge, room, screen_in, soup_case
from tb.golden.engine.icu.patches import CONFIG


def compared(scene, geometry, record):
    fixed, oracle = NaiveFixed(geometry, CONFIG).cast(record), Naive(scene).nearest(oracle_rays(record, geometry))
    return fixed, oracle, differences(fixed, oracle, record, scene, geometry, CONFIG)


@pytest.mark.parametrize("name", ["cornell", "lobby", "room1627"])
def test_rooms_differ_only_where_they_may(name):
    scene, geometry, record = room(name, 11)
    causes = compared(scene, geometry, record)[2].counts()
    assert causes["unexplained"] == causes["dropped"] == causes["long_edge"] == 0
    assert sum(causes.values()) < 1e-3 * len(record)
    if scene.camera:
        geometry, record = screen_in(scene, scene.camera)
        assert compared(scene, geometry, record)[2].counts()["unexplained"] == 0


@pytest.mark.parametrize("where", WHERE)
def test_soups_differ_only_where_they_may(where):
    total = {}
    for seed in range(100, 112):
        for cause, count in compared(*soup_case(seed, where))[2].counts().items():
            total[cause] = total.get(cause, 0) + count
    assert total["unexplained"] == 0
    assert where != "anywhere" or total["dropped"] == 0


@pytest.mark.parametrize("height", [1e-2, 1e-3, 1e-4, 1e-5])
def test_an_edge_much_nearer_than_it_is_long_differs_by_the_rounding_of_its_ends(height):
    total = {}
    for seed in range(4):
        for cause, count in compared(*long_edge(seed, height))[2].counts().items():
            total[cause] = total.get(cause, 0) + count
    assert total["unexplained"] == 0
    assert height > 1e-4 or total["long_edge"] > 0


def test_a_ray_near_an_edge_of_either_patch_alone_may_differ():
    """Of rays that hit the same patch, a miss instead has the same cause whichever of the two casters has it."""
    scene, geometry, record = room("room1627", 11)
    fixed, oracle, _ = compared(scene, geometry, record)
    patch, misses = np.where(fixed.patch == oracle.patch, fixed.patch, -1), np.full(len(record), -1)
    ours, theirs = (differences(replace(fixed, patch=one), replace(oracle, patch=other), record, scene, geometry,
                                CONFIG) for one, other in ((patch, misses), (misses, patch)))
    for cause in "edge", "long_edge", "unexplained":
        rays = getattr(ours, cause)
        assert len(rays) > 0
        np.testing.assert_array_equal(rays, getattr(theirs, cause))
    assert sum(ours.counts().values()) == (patch >= 0).sum()


def test_a_fault_is_unexplained():
    scene, geometry, record = room("cornell", 11)
    fixed, oracle, _ = compared(scene, geometry, record)
    hit = np.flatnonzero(fixed.patch >= 0)
    wrong = fixed.patch.copy()
    wrong[hit] = -1
    found = differences(FixedHits(inverse=fixed.inverse, patch=wrong, u=fixed.u, v=fixed.v), oracle, record, scene,
                        geometry, CONFIG)
    assert len(found.unexplained) > 0.98 * len(hit)
    assert sum(found.counts().values()) == len(hit)
