"""Simulated cast: the cycles of a section on one cluster, with the golden model's cells and tests.

Golden explores a few rows of a stage's grid rays when the simulated cluster requests them, with the settle codes that
survival has read by then. So grid rays, cells and tests follow from the simulated times.
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from golden.engine.cast.shelling import Shelling, ShellingCounts
from golden.engine.config import Config
from golden.engine.ctu.grid_rays import INDEX_FRACTION, GridRays
from golden.engine.ctu.sector import Sector, sector_rays, subshell_rays
from golden.engine.ctu.settle_pyramid import SettlePyramid
from golden.engine.frustum import FrustumRecord
from golden.engine.frustum.bundle import Bundle
from golden.engine.icu.section_clip import section_clip
from golden.engine.icu.window_walk import window_tiles
from golden.engine.schedule.cycle_model import BLOCK
from golden.engine.schedule.row_pieces import row_pieces
from golden.engine.schedule.square_scan import row_groups, survival_words
from golden.engine.schedule.subshells import SubshellList
from radiosity.machines.engine.cluster_cast import NO_CLUSTER, StageItems, clock, tested
from radiosity.machines.engine.cluster_timing import ClusterTiming
from radiosity.machines.engine.section_trace import CastTimes, SectionTrace, run_stages

__all__ = ["SimulatedCast", "cast_section"]

# Patches whose tests survival sees together; the most parts of a stage.
_PATCHES, _PARTS = 8, 16
# Before the first, and behind the last row or column of any frustum's grid rays.
_FIRST, _LAST = -1 << 20, 1 << 20
# Arrays of `GridRays` with an element for each row.
_OF_ROWS = ("direction", "first_row", "row_count", "first_column", "column_count", "row_position", "column_border",
            "row_table", "column_reach")


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedCast:
    """A section that has been cast.

    Parameters
    ----------
    trace, times
        Its work, and the cycles of its events.
    tests, cells, grid_rays, hit
        Tests, cells opened, grid rays that survived, and patches that sums name: those that rays hit, of a shadow
        frustum none.
    """

    trace: SectionTrace
    times: CastTimes
    tests: int
    cells: int
    grid_rays: int
    hit: int


def cast_section(shelling: Shelling, record: FrustumRecord, config: Config, timing: ClusterTiming, *,
                 section: Sector | None = None, subshells: SubshellList | None = None,
                 lanes: int = 1, others: np.ndarray | None = None, ahead: int = 0) -> SimulatedCast:
    """Cast a section of a frustum on one cluster alone.

    Parameters
    ----------
    shelling
        Shelling by settle codes, with ``icu.rays`` of at least the frustum's rays.
    record, config
        The frustum, and the configuration of ``shelling``.
    timing
        Latencies and capacities of a cluster.
    section
        The section. Default: all rays.
    subshells
        The subshells of the section, explored one after the other: each begins when all before it are over. Default:
        the last one alone.
    lanes
        Rays of a tile that are tested in a cycle; the hardware has one lane.
    others, ahead
        N bool: the patches that the cluster does not hold. They come at once, and so many of them at most are found
        and not read. Default: it holds all.
    """
    stages = _Stages(shelling, record, config, timing, section or Sector.whole(record), subshells, lanes, others)
    times = run_stages(stages, timing, slots=config.icu.slots, run_ahead=config.ctu.run_ahead, ahead=ahead)
    return SimulatedCast(trace=stages.trace(), times=times, tests=stages.tests, cells=stages.cells,
                       grid_rays=stages.grid_rays, hit=stages.hit)


class _Part(NamedTuple):
    """Rows of a stage that are requested together.

    Parameters
    ----------
    cycles
        In which the generator requests them.
    window
        Of intersection rays through which their grid rays pass, see `subshell_rays`. None: all.
    rays
        These grid rays. None: they are not looked up.
    """

    cycles: int
    window: tuple[int, int, int, int] | None
    rays: GridRays | None


class _Stages:
    """The stages of a section, each explored part by part when its grid rays are requested."""

    def __init__(self, shelling, record, config, timing, section, subshells, lanes, others):
        self._others = np.zeros(len(shelling.geometry), dtype=bool) if others is None else others
        self._shelling, self._record, self._config, self._timing = shelling, record, config, timing
        self._section, self._memory = section, shelling.memory(record)
        self._is_shadow = record.bundle == Bundle.SHADOW
        # An empty list is an item too.
        self.listing = timing.listing + max(1, len(section.among(record.listed, record))) if self._is_shadow else 0
        self._references = np.zeros(len(shelling.geometry), dtype=np.int64)
        self._tests = shelling.tests(record, self._memory, references=self._references, block=BLOCK, lanes=lanes)
        self._cluster = shelling.cluster(record, self._section)
        self._found, self.cells = np.zeros(len(shelling.geometry), dtype=bool), 0
        self._cycles, self._first_cell = [], [0]
        # Of all stages so far: times and offsets of cells, their lists, patches and their walks.
        self._time, self._offset, self._patch, self._walks = (np.empty(0, dtype=np.int64) for _ in range(4))
        self._entries, self._new = np.zeros(1, dtype=np.int64), np.empty(0, dtype=bool)
        # Stored inverse distances after so many patches, and before the first sweep: all rays may be hit.
        self._patches, self._inverse = [0], [self._memory.inverse.copy()]
        self._unknown = np.zeros(len(record), dtype=np.int64)
        side = 1 << config.icu.tile_bits
        self._tiles = -(-(section.end_row - section.first_row) // side) * -(
            -(section.end_column - section.first_column) // side)
        self.patches = len(shelling.geometry)
        self._where = [*self._cluster.schedule(subshells, self._tests.window)]
        subshell = np.array([one for one, _, _ in self._where])
        self.barriers = np.diff(subshell, prepend=0) > 0

    @property
    def tests(self):
        return int(self._references.sum())

    @property
    def grid_rays(self):
        return self._cluster.traversal.grid_rays

    @property
    def hit(self):
        own = self._section.mask(self._record).ravel()
        if self._is_shadow:
            return 0
        patch = self._memory.patch[own]
        return len(np.unique(patch[patch >= 0]))

    def trace(self):
        """All of it, for replays."""
        return SectionTrace(
            cycles=np.array(self._cycles),
            searches=np.array([self.searches(stage) for stage in range(len(self._where))]),
            is_barrier=self.barriers, first_cell=np.array(self._first_cell), offset=self._offset,
            entries=self._entries, is_new=self._new, patch=self._patch, tests=self._walks,
            listing=self.listing)

    def searches(self, stage):
        rays = self._cluster.traversal.rays(self._where[stage][1]) if stage else None
        return self._timing.search * (rays.rows.bit_length() + rays.columns.bit_length()) if stage else 0

    def items(self, stage, begin, cast):
        self._cycles.append(0)
        self._first_cell.append(len(self._offset))
        self._parts = self._divided(stage)
        return self.part(begin, cast)

    def has_part(self):
        return bool(self._parts)

    def part(self, begin, cast):
        """The items of all stages up to the next part of this one, whose requests begin; and their cycles."""
        stage, part, before = len(self._cycles) - 1, self._parts.pop(0), self._cycles[-1]
        timing, (subshell, shell, _), inverse = self._timing, self._where[stage], self._unknown
        if stage:
            # Codes improve while survival looks rays up: those of the middle stand for all of the part.
            inverse = self._seen(cast, begin + self._requests(part, shell, self._seen(cast, begin), None) // 2)
        explored = self._cluster.explore(subshell, shell, part.window, inverse)
        cells = np.empty(0, dtype=np.int64) if explored is None else explored.cells
        if stage:
            cycles = self._requests(part, shell, inverse, explored)
            offset = (np.arange(len(cells)) + 1) * cycles // max(1, len(cells))
        else:
            cycles, offset = len(cells), np.arange(len(cells))
        latency = timing.memory + (timing.traversal if stage else 0)
        self._time = np.append(self._time, clock(cast, begin) + latency + offset)
        self._offset = np.append(self._offset, before + offset)
        self._cycles[-1] += cycles
        self._first_cell[-1] = len(self._offset)
        if explored is not None:
            self._append_lists(cells, explored)
            self._append_tests(explored)
        owner = np.where(self._others[self._patch], NO_CLUSTER, -1)
        return StageItems(self._time, self._entries, self._new, self._walks, owner), cycles

    def _divided(self, stage):
        """The parts of a stage, in their order."""
        _, shell, window = self._where[stage]
        if not stage:
            return [_Part(0, window, None)]
        rays = self._cluster.traversal.rays(shell)
        if window is not None:
            return [_Part(self._window_requests(rays, window), window, None)]
        row, cycles = self._row_requests(rays)
        position = rays.row_position >> INDEX_FRACTION
        first = position[row[len(row) * np.arange(_PARTS) // _PARTS]] if len(row) else []
        parts = []
        for low, end in pairwise([_FIRST, *np.unique(first)[1:].tolist(), _LAST]):
            which = (position >= low) & (position < end)
            parts.append(_Part(int(cycles[which[row]].sum()), (_FIRST, _LAST - _FIRST, low, end - low),
                               _rows(rays, which)))
        return parts

    def _seen(self, cast, now):
        """Stored inverse distances as the sweep has read them: on average half of a sweep ago."""
        if now < self._timing.begin + self.listing + self._tiles + self._timing.sweep:
            return self._unknown
        done = tested(cast, now - self._tiles // 2 - self._timing.sweep)
        return self._inverse[np.searchsorted(self._patches, done, side="right") - 1]

    def _append_tests(self, stage):
        """Test the patches, and keep the stored inverse distances in between, since survival reads them any time."""
        self.cells += len(stage.opened)
        clip = section_clip(self._tests.patches.window[stage.found], self._section, self._record)
        before = self._tests.issued.copy()
        done = len(self._walks)
        for part in np.array_split(stage.found, max(1, len(stage.found) // _PATCHES)):
            self._tests.run(replace(stage, found=part), self._section, ShellingCounts())
            done += len(part)
            self._patches.append(done)
            self._inverse.append(self._memory.inverse.copy())
        issued = (self._tests.issued - before)[stage.found]
        self._patch = np.append(self._patch, stage.found)
        self._walks = np.append(self._walks, np.maximum(issued, window_tiles(clip, self._config.icu)))

    def _append_lists(self, cells, stage):
        """Which of the cells are open, and which of the others' patches have been found."""
        table = self._shelling.table
        opens = _is_first(cells) & np.isin(cells, stage.opened)
        count = np.where(opens, table.count[cells], 0)
        listed = table.patches.read(table.entries(cells[opens]))
        is_new = _is_first(listed) & ~self._found[listed]
        self._found[listed] = True
        self._entries = np.append(self._entries, self._entries[-1] + np.cumsum(count))
        self._new = np.append(self._new, is_new)

    def _requests(self, part, shell, inverse, stage):
        """Cycles in which a part's grid rays are requested, looked up and traversed: queues between them are short."""
        record, config, cycles = self._record, self._config, part.cycles
        if part.rays is not None:
            live = SettlePyramid.of(inverse.reshape(record.rows, record.columns), self._section, config).live(
                self._cluster.traversal.threshold(shell, config))
            words, lookups = survival_words(part.rays, live, self._section, record, config)
            cycles = max(cycles, lookups, *words)
        if stage is None:
            return cycles
        passes = -(-stage.passes // config.ctu.traversal_pipelines(config.noc.clusters))
        return max(cycles, stage.grid_rays, passes, len(stage.cells))

    def _window_requests(self, rays, window):
        """Cycles in which the grid rays of a subshell's window are requested: one in each, row by row."""
        inside = sector_rays(rays, self._section, self._record) & subshell_rays(rays, window, self._record)
        of_rows = np.count_nonzero(inside, axis=1)
        timing = self._timing
        search = timing.arc + timing.search * rays.columns.bit_length()
        return search + int(np.maximum(of_rows, timing.row + timing.piece)[of_rows > 0].sum())

    def _row_requests(self, rays):
        """The rows of a stage, and cycles in which the generator requests each, with its searches for columns."""
        timing, pieces = self._timing, row_pieces(rays, self._section, self._record)
        search = timing.arc + timing.search * rays.columns.bit_length()
        groups = np.bincount(row_groups(rays, self._section, self._record).row, minlength=rays.rows)[pieces.row]
        cycles = timing.row + timing.piece * pieces.pieces + search * pieces.searches
        # Requests of the first row cannot overlap its search.
        cycles[:1] -= search
        cycles = np.maximum(cycles, groups)
        cycles[:1] += search
        return pieces.row, cycles


def _rows(rays, which):
    """Some rows of a shell's grid rays."""
    return replace(rays, **{name: getattr(rays, name)[which] for name in _OF_ROWS})


def _is_first(numbers):
    """Whether each number is the first of its value."""
    first = np.zeros(len(numbers), dtype=bool)
    first[np.unique(numbers, return_index=True)[1]] = True
    return first
