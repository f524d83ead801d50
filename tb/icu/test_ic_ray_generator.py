import numpy as np
import pytest

from golden.engine.ctu.sector import Sector
from golden.engine.icu.section_clip import section_clip
from golden.engine.icu.settle_code import settle_code
from golden.engine.icu.window_walk import ray_address, walk_cycles, window_rays
from golden.engine.stimulus.frusta import random_hemisphere
from golden.engine.stimulus.icu.section_clip import draw_windows
from hw.icu.ic_ray_generator import IcRayGenerator
from radiosity.flow.package.example.frustum_load import tiles
from tb.icu.vectors import section_window_of
from tb.lib.configurations import config_of
from tb.lib.coverage import Coverage
from tb.lib.responder import Responder
from tb.lib.schedules import Schedule, ScheduleBench

WINDOWS = 60
# Of sections.
BOUNDS = [(0, None, 0, None), (0, 20, 3, 9), (11, 43, 2, None)]
CASES = ("window without rays", "window of one ray", "window in two pieces", "ray skipped", "tile skipped",
         "last tile without a ray that may improve", "window without a ray that may improve",
         "whole window may improve", "ray of the largest code that may improve", "code just below the threshold",
         "code at the threshold")


class Walk:
    """Windows over a settle map."""

    def __init__(self, *, tile_bits, bounds, seed, choose=None):
        self.config = config = config_of({"icu.tile_bits": tile_bits, "icu.generation_bits": 2})
        random = np.random.default_rng(seed)
        record = random_hemisphere(random, config)
        first, end, top, bottom = bounds
        self.section = section = Sector(first, end or record.columns, top, bottom or record.rows)
        given = draw_windows(random, record, WINDOWS)
        given.column_count[8:24] = given.row_count[8:24] = 1
        if choose is not None:
            given = choose(given)
        self.windows, self.across = section_clip(given, section, record), tiles(section, config)[0]
        columns, rows = np.meshgrid(np.arange(section.end_column - section.first_column),
                                    np.arange(section.end_row - section.first_row))
        self.addresses = ray_address(columns.ravel(), rows.ravel(), self.across, config.icu)
        self.inverse = np.zeros(config.icu.rays, dtype=np.int64)
        # Every other tile has no ray without a hit, and there the hits are near.
        full = (self.addresses >> 2 * tile_bits) % 2 == 0
        settled = (random.random(len(self.addresses)) < 0.6) | full
        near = np.where(full, (5 << 21) + random.integers(1 << 21, size=len(full)),
                        random.integers(1 << 22, 3 << 22, len(full)))
        self.inverse[self.addresses[settled]] = near[settled]
        self.threshold = random.integers(1, config.icu.settle.high + 2, WINDOWS)
        self.threshold[::3] = config.icu.settle.high + 1
        self.threshold[1::6] = random.integers(1, 8, len(self.threshold[1::6]))
        self.coverage = Coverage(CASES)

    def expected(self):
        """The rays in order, and how many of each window there are."""
        code, rays, live = settle_code(self.inverse, self.config), [], np.zeros(WINDOWS, dtype=int)
        side = 2 * self.config.icu.tile_bits
        for which in range(WINDOWS):
            columns, rows = window_rays(self.windows, which, self.config.icu)
            address = ray_address(columns, rows, self.across, self.config.icu)
            may = code[address] < self.threshold[which]
            live[which] = may.sum()
            tile = address >> side
            some = np.isin(tile, tile[may])
            self.coverage.hit_all({
                "window without rays": len(address) == 0, "window of one ray": len(address) == 1,
                "window in two pieces": self.windows.wrapped_count[which] > 0,
                "ray skipped": ~may, "tile skipped": ~some & (tile != tile[-1:]),
                "last tile without a ray that may improve": len(address) > 0 and not some[-1],
                "window without a ray that may improve": len(address) > 0 and not may.any(),
                "whole window may improve": len(address) > 0 and may.all(),
                "ray of the largest code that may improve": may & (code[address] == self.config.icu.settle.high),
                "code just below the threshold": code[address] == self.threshold[which] - 1,
                "code at the threshold": code[address] == self.threshold[which]})
            rays += [(which % 64, int(ray), int(column) + self.section.first_column, int(row) + self.section.first_row)
                     for ray, column, row in zip(address[may], columns[may], rows[may], strict=True)]
        return rays, live

    def run(self):
        """Rays that were issued, rays visited, and cycles from the first beat to the last."""
        config, section = self.config, self.section
        bench = ScheduleBench(IcRayGenerator(config=config), watchdog=100_000, watched=["visited"])
        words = settle_code(self.inverse, config).reshape(-1, 1 << 2 * config.icu.tile_bits).tolist()
        settle_map = Responder("o_walk", "i_walk", lambda read: [{"tag": read["tag"], "word": words[read["tile"]]}])
        beats = bench.run(Schedule(items={"i": [(0, {
            "slot": which % 64, "window": section_window_of(self.windows, which),
            "threshold": int(self.threshold[which])}) for which in range(WINDOWS)]}), settle_map,
            tiles_across=self.across, section={name: getattr(section, name) for name in (
                "first_column", "end_column", "first_row", "end_row")})["o"]
        assert sum(beat["last"] for beat in beats) == WINDOWS
        cycles, issued = bench.cycles["o"], [tuple(beat[name] for name in ("slot", "ray", "column", "row"))
                                             for beat in beats if beat["is_ray"]]
        return issued, sum(bench.history["visited"]), cycles[-1] - cycles[0] + 1


# A commit's tests have the two smaller sizes of tiles, each with one of the bounds.
@pytest.mark.parametrize(("tile_bits", "bounds"), [
    pytest.param(tile_bits, bounds, id=f"{tile_bits}-{bounds}", marks=[] if number + 1 == tile_bits < 3 else
                 pytest.mark.nightly) for tile_bits in (1, 2, 3) for number, bounds in enumerate(BOUNDS)])
def test_the_rays_that_may_improve_are_issued_in_order_and_in_time(tile_bits, bounds):
    walk = Walk(tile_bits=tile_bits, bounds=bounds, seed=4)
    issued, visited, cycles = walk.run()
    expected, live = walk.expected()
    assert issued == expected
    assert visited == walk.windows.rays.sum()
    # One cycle more per window where its last tile has no ray.
    assert live.sum() <= cycles <= walk_cycles(walk.windows, live, walk.config.icu).sum() + WINDOWS


@pytest.mark.parametrize("tile_bits", [1, 2, 3])
def test_the_walks_hold_every_case(tile_bits):
    coverage = Coverage(CASES)
    for bounds in BOUNDS:
        walk = Walk(tile_bits=tile_bits, bounds=bounds, seed=4)
        walk.coverage = coverage
        walk.expected()
    coverage.check()


def test_windows_of_one_ray_are_issued_in_consecutive_cycles():
    def one_ray(given):
        return given.__class__(given.column_first * 0 + 5, given.column_count * 0 + 1, given.row_first * 0 + 3,
                               given.row_count * 0 + 1)

    walk = Walk(tile_bits=2, bounds=(0, None, 0, None), seed=6, choose=one_ray)
    walk.inverse[:] = 0
    issued, _, cycles = walk.run()
    assert len(issued) == cycles == WINDOWS
    assert len({ray for _, ray, _, _ in issued}) == 1
