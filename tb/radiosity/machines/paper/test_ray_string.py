"""The string of references is that of rays followed in float64, from crossing to crossing."""

import numpy as np
import pytest

from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.cast.shelling import Shelling
from golden.engine.config import PRESETS
from golden.engine.ctu.cell_traversal import POSITION_FRACTION
from golden.engine.ctu.unit import global_directions
from golden.engine.frustum import hemisphere_record
from golden.engine.icu.inverse_distance import decode
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.ceiling_points import ceiling_points
from golden.scene.open import open_scene
from radiosity.machines.paper.ray_string import ray_string

CONFIG = PRESETS["paper"]


def followed(record, hits, table):
    """The patches that each ray refers to, in order, from cells around the middles of crossings."""
    origin = table.position(record.origin) * 2.0**-POSITION_FRACTION
    directions = global_directions(record.all_directions(), record) * 2.0**-16
    inverse, unit = decode(hits.inverse, CONFIG.numbers), CONFIG.numbers.scene.decode(np.array(table.cell))
    borders = [np.arange(size + 1) for size in table.shape]
    for direction, one in zip(directions, inverse, strict=True):
        end = 1 / one / unit if one > 0 else np.inf
        with np.errstate(divide="ignore", invalid="ignore"):
            crossed = np.concatenate([(border - start) / along for border, start, along in zip(
                borders, origin, direction, strict=True)])
        times = np.unique(crossed[(crossed > 0) & (crossed < end)])
        times = np.concatenate([[0], times, [end] if np.isfinite(end) else []])
        index = np.floor(origin + (times[:-1] + times[1:])[:, None] / 2 * direction).astype(np.int64)
        index = index[((index >= 0) & (index < table.shape)).all(axis=1)]
        yield dict.fromkeys(table.patches.read(table.entries(table.number(index))).tolist())


def cast(cell):
    """A hemisphere under the ceiling of the lobby."""
    scene = open_scene("lobby")
    points, down = ceiling_points(scene)
    geometry = PatchGeometry.of(scene, CONFIG.numbers, points[[5]])
    record = hemisphere_record(Hemisphere(16, 8), geometry.coordinates, points[5], down)
    shelling = Shelling(geometry, CONFIG, cell=cell)
    return record, shelling.cast(record)[0], shelling.table


def test_references_are_those_of_rays_in_float64():
    record, hits, table = cast(0.1)
    found = ray_string(record, hits, table, CONFIG)
    expected = [patch for patches in followed(record, hits, table) for patch in patches]
    # A ray through an edge of two cells may refer to either.
    assert abs(len(found) - len(expected)) < 0.01 * len(expected)
    of_patch = [np.bincount(np.array(each, dtype=np.int64), minlength=227) for each in (found, expected)]
    assert abs(of_patch[0] - of_patch[1]).sum() < 0.01 * len(expected)


# Walls are on borders of cells of 1/8.
@pytest.mark.parametrize("cell", [0.1, 0.125])
def test_a_ray_refers_to_the_patch_that_it_hits(cell):
    record, hits, table = cast(cell)
    hit = np.bincount(hits.patch[hits.patch >= 0], minlength=227)
    assert (np.bincount(ray_string(record, hits, table, CONFIG), minlength=227) >= hit).all()


def test_a_ray_ends_at_its_hit():
    record, hits, table = cast(0.1)
    none = FixedHits(**{name: np.full(len(record), -1 if name == "patch" else 0) for name in (
        "inverse", "patch", "u", "v")})
    assert len(ray_string(record, none, table, CONFIG)) > 1.05 * len(ray_string(record, hits, table, CONFIG))


def test_a_ray_refers_to_a_patch_once():
    record, hits, table = cast(0.1)
    assert np.bincount(ray_string(record, hits, table, CONFIG)).max() <= len(record)
