"""Hits beside a patch that is seen at grazing incidence: the limit of shelling's exactness (docs/exactness.md).

A closed box around the origin has a hole that lets one ray out. Patch `GRAZED` has its near edge beside this ray by
less than half a unit of V', which rounds the edge onto the ray; its far edge is a unit beside it. So the ray hits the
patch at the distance at which it meets the plane, up to two cells before the near edge. Patch `FACED` is between.
"""

import numpy as np
import pytest

from golden.cast.frame import frame
from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.ctu import margins
from golden.engine.ctu.unit import CellTraversalUnit
from golden.engine.frustum import hemisphere_record
from golden.engine.icu.inverse_distance import decode
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.scene.g_coordinates import GCoordinates
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.builtin import builtin_scene
from tb.golden.cast.frusta import CELLS, CONFIG, RandomFrustum, room
from tb.golden.cast.shutters import shuttered, stays

FACED, GRAZED, LENGTH = 8, 9, 2.0


def grazing(seed, ray):
    """The first frustum of a search in which the ray's nearest hit by brute force is on `GRAZED`."""
    random = np.random.default_rng(seed)
    origin, normal = random.uniform(6, 10, 3), random.normal(size=3)
    normal /= np.linalg.norm(normal)
    coordinates = GCoordinates.of(room(), CONFIG.numbers, [origin])
    record = hemisphere_record(Hemisphere(64, 16), coordinates, origin, normal)
    table = CellTable(coordinates.integers(room().vertices), cell=coordinates.cell_size(1 / CELLS))
    unit, alone, opened = CellTraversalUnit(record, table), np.zeros((16, 64), dtype=bool), {}
    alone.ravel()[ray] = True
    for shell in range(1, 10):
        for cell in unit.open(shell, alone).tolist():
            opened.setdefault(cell, shell)
    direction = record.all_directions()[ray] @ record.to_global.T / 2.0**32
    direction /= np.linalg.norm(direction)
    along = [(opened.get(int(table.number(cell)), 10), begin, end) for cell, begin, end in stays(record, table, ray)]
    box = shuttered(frame(normal), origin, direction, distance=2.0).vertices[:8]
    for _, begin, _ in along:
        near = begin + 0.02
        shell = min([shell for shell, first, last in along if last > near and first < near + LENGTH], default=10)
        before = unit.settled(shell) * 2.0**24 / table.cell - 0.01
        if not (2 < begin < 7.5 and shell < 10 and near - before < 1.1):
            continue
        for _ in range(60):
            beside = np.cumsum(random.uniform([0.05, 0.3], [0.5, 1.2])) * 2.0**-17 * near
            up = np.cross(direction, random.normal(size=3))
            up /= np.linalg.norm(up)
            side = np.cross(direction, up)
            first = origin + near * direction - beside[0] * up
            second = origin + (near + LENGTH) * direction - beside[1] * up
            grazed = np.array([first - 0.02 * side, first + 0.02 * side, second + 0.02 * side, second - 0.02 * side])
            faced = origin + before * direction + 0.02 * np.array([-up - side, up - side, up + side, side - up])
            scene = room(np.concatenate([box, [faced, grazed]]))
            frustum = RandomFrustum(seed, PatchGeometry.of(scene, CONFIG.numbers, [origin]), record, 1 / CELLS)
            if frustum.naive().patch[ray] == GRAZED:
                return frustum
    return None


@pytest.mark.parametrize(("seed", "ray"), [pytest.param(1, 551, marks=pytest.mark.nightly), (2, 118)])
def test_shelling_may_lose_a_hit_that_is_beside_its_patch(seed, ray):
    frustum = grazing(seed, ray)
    naive, (shelling, _) = frustum.naive(), frustum.shelling()
    assert naive.differences(shelling).tolist() == [ray]
    assert (naive.patch[ray], shelling.patch[ray]) == (GRAZED, FACED)
    # The lost hit is nearer than the whole patch by more than the slack; shelling's own hit is that of the exact scene.
    offset = (frustum.geometry.vertices[GRAZED] - frustum.record.origin) * (CELLS / (1 - 2 * 2.0**-10)) / 2.0**24
    assert np.linalg.norm(offset, axis=1).min() - 16 * distances(naive)[ray] > 100 * margins.slack(8)


def distances(hits):
    """Distance of each hit in units of the G cube, inf for none."""
    with np.errstate(divide="ignore"):
        return 1 / decode(hits.inverse, CONFIG.numbers)


def beside(geometry, record, hits):
    """Largest distance of a hit from its patch's box along an axis, in units of G."""
    hit = np.flatnonzero(hits.patch >= 0)
    direction = record.all_directions()[hit] @ record.to_global.T / 2.0**32
    point = record.origin + distances(hits)[hit, None] * direction * 2.0**24
    vertices = geometry.vertices[hits.patch[hit]]
    return np.maximum(np.maximum(vertices.min(axis=1) - point, point - vertices.max(axis=1)), 0).max(initial=0)


@pytest.mark.parametrize("name", ["cornell", "teapot:4"])
def test_hits_of_rooms_are_on_their_patches_within_the_slack(name):
    scene = builtin_scene(name)
    for seed in range(3):
        random = np.random.default_rng(seed)
        origin = scene.bounds[0] + random.uniform(0.1, 0.9, 3) * np.ptp(scene.bounds, axis=0)
        geometry = PatchGeometry.of(scene, CONFIG.numbers, [origin])
        record = hemisphere_record(Hemisphere(128, 32), geometry.coordinates, origin, random.normal(size=3))
        hits = NaiveFixed(geometry, CONFIG).cast(record)
        assert beside(geometry, record, hits) < margins.slack(2) * 2**24 / CELLS
