"""What the frusta of the intersection unit's bench are made of, case by case, from stimulus and golden."""

import numpy as np

from golden.engine.ctu.sector import Sector
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.intersection import intersect
from golden.engine.icu.patch_setup import PatchSetup
from golden.engine.icu.section_clip import section_clip
from golden.engine.icu.window_walk import window_tiles
from golden.engine.scene.patch_geometry import PatchGeometry
from tb.icu.unit_bench import UnitBench
from tb.lib.coverage import Coverage

__all__ = ["COVERAGE", "CoveredBench"]

FRUSTA = ("hemisphere", "screen", "section", "the other bank", "a bank whose tags ran out")
PATCHES = ("quad", "triangle", "patch in two triangles", "patch dropped", "the source's own patch",
           "patch seen edge-on", "patch through the plane of the eye", "patch behind the eye",
           "patch around the pole")
WINDOWS = ("window without rays", "window of one ray", "window of one tile", "window in one piece",
           "window in two pieces", "window of all columns", "window cut by the section",
           "window of one ray after another one on the same ray")
HITS = ("first hit of a ray", "nearer hit", "farther hit", "equally near with a smaller id",
        "equally near with a larger id")
UV_CASES = ("no hit", "u smallest", "u largest", "v smallest", "v largest")
FLOW = ("rays skipped", "all rays issued", "vertices wait", "no vertex waits", "as many patches in flight as slots",
        "tokens wait")
# Of all coroutines that run in one simulation.
COVERAGE = Coverage((*FRUSTA, *PATCHES, *WINDOWS, *HITS, *UV_CASES, *FLOW))


class CoveredBench(UnitBench):
    """An intersection unit's streams, of which each frustum counts for `COVERAGE`."""

    def __init__(self, dut, config, **stalls):
        super().__init__(dut, config, **stalls)
        self._begun, self._frustum = 0, None

    async def begin(self, record: FrustumRecord, section: Sector, weights=None) -> None:
        """See `UnitBench.begin`."""
        await super().begin(record, section, weights)
        self._begun += 1
        self._frustum = record, section
        COVERAGE.hit_all({
            "hemisphere": not record.is_screen, "screen": record.is_screen, "section": section != Sector.whole(record),
            "the other bank": self._begun > 1,
            "a bank whose tags ran out": self._begun > 2 * ((1 << self.config.icu.generation_bits) - 1)})

    async def cast(self, geometry: PatchGeometry, order: np.ndarray) -> None:
        """See `UnitBench.cast`."""
        # What has occurred already is not worked out again.
        if not COVERAGE.has((*PATCHES, *WINDOWS, *HITS)):
            self._count(geometry, order)
        await super().cast(geometry, order)
        counters = self.ports["counters"]
        COVERAGE.hit_all({
            "rays skipped": counters["issued"] < counters["visited"],
            "all rays issued": counters["issued"] == counters["visited"] > 0,
            "vertices wait": counters["waits_for_slot"] > 0, "no vertex waits": counters["waits_for_slot"] == 0})

    async def hits(self, section: Sector):
        """See `UnitBench.hits`."""
        found = await super().hits(section)
        most, hit = self.config.icu.uv.high, found.patch >= 0
        COVERAGE.hit_all({
            "no hit": ~hit, "u smallest": hit & (found.u == 0), "u largest": hit & (found.u == most),
            "v smallest": hit & (found.v == 0), "v largest": hit & (found.v == most)})
        return found

    def _count(self, geometry, order):
        (record, section), config = self._frustum, self.config
        patches = PatchSetup(record, config).patches(geometry)
        COVERAGE.hit_all(patch_cases(patches, geometry, record))
        clipped = section_clip(patches.window, section, record)
        COVERAGE.hit_all(window_cases(patches, clipped, record, order, config))
        COVERAGE.hit_all(hit_cases(patches, record, section, order, config))


def patch_cases(patches, geometry, record) -> dict:
    """Of each patch of a scene, seen from a frustum."""
    vertices, live = geometry.vertices, patches.live
    triangle, oriented = (vertices[:, 2] == vertices[:, 3]).all(axis=1), patches.planes.orientation.any(axis=1)
    height = (vertices - record.origin) @ record.matrix[2]
    own, dropped = (geometry.surface == record.source) & (record.source >= 0), patches.factor.dropped
    window = patches.window
    return {
        "quad": live & ~triangle, "triangle": live & triangle, "patch in two triangles": live & patches.planes.split,
        "patch dropped": dropped & ~own, "the source's own patch": own, "patch seen edge-on": ~oriented & ~own,
        "patch through the plane of the eye": live & (height.min(axis=1) < 0) & (height.max(axis=1) > 0),
        "patch behind the eye": live & (height.max(axis=1) < 0),
        "patch around the pole": live & (not record.is_screen) & (window.row_first == 0)
        & (window.column_count == record.columns)}


def window_cases(patches, clipped, record, order, config) -> dict:
    """Of each window in its section, in the order in which they are walked."""
    rays, given = clipped.rays, patches.window.rays
    one = rays[order] == 1
    first_ray = (clipped.column_first + clipped.row_first * record.columns)[order]
    return {
        "window without rays": rays == 0, "window of one ray": rays == 1,
        "window of one tile": (rays > 1) & (window_tiles(clipped, config.icu) == 1),
        "window in one piece": (rays > 0) & (clipped.wrapped_count == 0),
        "window in two pieces": clipped.wrapped_count > 0,
        "window of all columns": clipped.column_count + clipped.wrapped_count == record.columns,
        "window cut by the section": (rays > 0) & (rays < given),
        "window of one ray after another one on the same ray": one[1:] & one[:-1] & (first_ray[1:] == first_ray[:-1])}


def hit_cases(patches, record, section, order, config) -> dict:
    """Of each hit, against what its ray had before, in the order of the patches."""
    which, column, row = patches.window.pairs(record.columns)
    inside = section.mask(record)[row, column]
    which, ray = which[inside], (row * record.columns + column)[inside]
    pair, inverse = intersect(patches, which, record.all_directions()[ray], config)
    patch, ray = which[pair], ray[pair]
    position = np.full(len(patches.live), len(order))
    position[order[::-1]] = np.arange(len(order))[::-1]
    by = np.lexsort((position[patch], ray))
    by = by[position[patch[by]] < len(order)]
    patch, ray, inverse = patch[by], ray[by], inverse[by]
    # The best of each ray so far: ranks of 1/t above the complement of the id.
    keys, rank = np.unique((inverse << config.icu.patch_bits) + (1 << config.icu.patch_bits) - 1 - patch,
                           return_inverse=True)
    best = np.maximum.accumulate((ray << 32) + rank)[:-1] if len(ray) else ray
    before = np.zeros(len(ray), dtype=np.int64)
    before[1:] = keys[best & ((1 << 32) - 1)] if len(ray) else 0
    first = np.ones(len(ray), dtype=bool)
    first[1:] = ray[1:] != ray[:-1]
    had = before >> config.icu.patch_bits
    nearer = keys[rank] > before if len(ray) else first
    return {"first hit of a ray": first,
            "nearer hit": ~first & (inverse > had), "farther hit": ~first & (inverse < had),
            "equally near with a smaller id": ~first & (inverse == had) & nearer,
            "equally near with a larger id": ~first & (inverse == had) & ~nearer}
