"""Golden's brute force and shelling against the rule written from the pages alone, every field of every ray."""

import numpy as np
import pytest

from benchmarks.independent_hits import ray_directions, rule_hits
from benchmarks.truth import ray_tiles
from benchmarks.viewpoints import CONFIG, hard_records
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.cast.shelling import Shelling
from golden.scene.open import open_scene
from tb.golden.soups import soup

# `make nightly` has the larger ones.
SCENES = ("cornell", "lobby", *(pytest.param(name, marks=pytest.mark.nightly)
                                for name in ("room1627", "teapot:4", "tetra:3")))


def differing(hits, rule):
    """Numbers of the rays that differ in a field."""
    return np.flatnonzero(np.any([getattr(hits, field) != values for field, values in vars(rule).items()], axis=0))


def frusta(scene, seed, *, origins=2, rays=(32, 16), pixels=(24, 18)):
    return hard_records(scene, origins=origins, rays=rays, pixels=pixels, seed=seed)


@pytest.mark.parametrize("name", SCENES)
def test_hits_are_those_of_the_rule_of_the_pages(name):
    geometry, records = frusta(open_scene(name), 3)
    for record in records:
        assert not len(differing(NaiveFixed(geometry, CONFIG).cast(record), rule_hits(record, geometry)))


@pytest.mark.parametrize("seed", range(4))
def test_slivers_doubled_patches_and_hard_origins_have_the_hits_of_the_rule(seed):
    geometry, records = frusta(soup(seed), seed, origins=4)
    shelling = Shelling(geometry, CONFIG, cell=0.125)
    for record in records:
        rule = rule_hits(record, geometry)
        assert not len(differing(NaiveFixed(geometry, CONFIG).cast(record), rule))
        assert not len(differing(shelling.cast(record)[0], rule))


@pytest.mark.parametrize("seed", range(2))
def test_no_number_of_the_rule_leaves_the_range_of_int64(seed):
    geometry, records = frusta(soup(seed), seed)
    hit = 0
    for record in records:
        bounded, unbounded = (rule_hits(record, geometry, numbers) for numbers in (np.int64, object))
        assert not len(differing(bounded, unbounded))
        hit += np.count_nonzero(bounded.patch >= 0)
    assert hit > 100


def test_tiles_leave_out_no_hit(monkeypatch):
    """One tile holds all rays, so that a patch with any hit is tested against every ray."""
    geometry, records = frusta(open_scene("cornell"), 5)
    fine = [rule_hits(record, geometry) for record in records]
    monkeypatch.setattr(ray_tiles.RayTiles, "SIDE", 1 << 12)
    for record, hits in zip(records, fine, strict=True):
        assert not len(differing(hits, rule_hits(record, geometry)))


@pytest.mark.parametrize("sizes", [(64, 16), (4, 4), (512, 128)])
def test_directions_are_those_of_the_record(sizes):
    _, records = frusta(open_scene("cornell"), 7, origins=1, rays=sizes, pixels=(37, 22))
    for record in records:
        np.testing.assert_array_equal(ray_directions(record).reshape(-1, 3), record.all_directions())
