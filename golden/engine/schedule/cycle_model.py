"""Cycle model: the cycles of a frustum on one cluster, from golden's counts of its stages."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from golden.engine.cast.shelling import Shelling, ShellingCounts
from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.ctu.settle_pyramid import SettlePyramid
from golden.engine.frustum import FrustumRecord
from golden.engine.schedule.square_scan import GROUP, survival_words

__all__ = ["CycleModel", "StageWork", "least_cycles", "stage_work"]

# Rays whose tests overlap: the machine's tests see what others found that many rays before.
BLOCK = 256
# Cycles of the machine: from the begin to the first near cell's patch; the least for a row of grid rays; a patch of the
# resident set, and of main memory; from a patch to its first test; from the last test to the begin of the next frustum.
START, ROW, PATCH, FETCH, SETUP, END = 45, 5, 4, 6, 170, 95
# Cells between traversal and the patches that wait for a slot.
CELLS = 64


@dataclass(frozen=True, kw_only=True, eq=False)
class StageWork:
    """Work of one shell on one cluster.

    Parameters
    ----------
    shell
        Its number.
    rows
        Cycles in which its rows of grid rays are generated.
    words
        Words that survival reads, the most of all levels.
    grid_rays, passes, cells
        Surviving grid rays, their traversal passes, and the cells that they meet.
    tests
        P int64: tests of each patch found, in the order of discovery.
    """

    shell: int
    rows: int = 0
    words: int = 0
    grid_rays: int = 0
    passes: int = 0
    cells: int = 0
    tests: np.ndarray


def least_cycles(patches: int) -> int:
    """Cycles of a section that finds so many patches, without tests."""
    return START + PATCH * patches + SETUP + END


def stage_work(shelling: Shelling, record: FrustumRecord, config: Config) -> Iterator[StageWork]:
    """The stages of a frustum, each computed when it is first read.

    Parameters
    ----------
    shelling
        Shelling by settle codes, with ``icu.rays`` of at least the frustum's rays.
    record, config
        The frustum, and the configuration of ``shelling``.
    """
    section, memory = Sector.whole(record), shelling.memory(record)
    references = np.zeros(len(shelling.geometry), dtype=np.int64)
    tests = shelling.tests(record, memory, references=references, block=BLOCK)
    cluster = shelling.cluster(record, section)
    traversal, shape = cluster.traversal, (record.rows, record.columns)
    for where in cluster.schedule(None, tests.window):
        shell, rows, words = where[1], 0, 0
        if shell > 1:
            rays = traversal.rays(shell)
            live = SettlePyramid.of(memory.inverse.reshape(shape), section, config).live(
                traversal.threshold(shell, config))
            words = max(survival_words(rays, live, section, record, config)[0])
            rows = rays.rows * max(ROW, -(-rays.columns // GROUP))
        stage = cluster.explore(*where, memory.inverse)
        if stage is None:
            return
        before = references.copy()
        tests.run(stage, section, ShellingCounts())
        yield StageWork(shell=shell, rows=rows, words=words, grid_rays=stage.grid_rays, passes=stage.passes,
                        cells=len(stage.cells), tests=(references - before)[stage.found])


class CycleModel:
    """Servers in a line: traversal with survival, patches, tests. Each takes its items in order.

    * Traversal takes a stage after the other: the largest of rows, words of survival, grid rays sent with the groups
      that they were looked up in, passes divided by the pipelines, and cells. Its cells are evenly spread over that
      time, and wait when `CELLS` of them do.
    * While earlier tests are outstanding settle codes are old, so a share of survival's lookups ends with its first
      word: the share of those patches whose tests have not ended.
    * A patch takes `PATCH` cycles, or `FETCH` beyond the resident set, and a slot until its last test.
    * Tests take a cycle each, a patch without tests one.
    * After ``ctu.run_ahead`` + 1 stages traversal waits until no patch is in flight.

    Parameters
    ----------
    config
        The machine's configuration.
    patches
        Patches of the scene.

    Members
    -------
    cycles
        Cycles of the stages so far.
    """

    def __init__(self, config: Config, *, patches: int):
        self._config = config
        self._pipelines = config.ctu.traversal_pipelines(1)
        # The resident set is a share of the patches of each stage.
        share = min(1.0, config.memsys.own_patches / max(1, patches))
        self._fetch = PATCH * share + FETCH * (1 - share)
        self._traversed = self._tested = self._entered = float(START)
        self._ends: list[float] = []
        self._left: list[float] = []
        self._stages = 0

    @property
    def cycles(self) -> int:
        """See `CycleModel`."""
        return int(max(self._tested, self._traversed, self._entered)) + END

    def add(self, work: StageWork) -> None:
        """The next stage."""
        if work.shell > 1:
            if self._stages > self._config.ctu.run_ahead:
                self._traversed, self._stages = max(self._traversed, self._tested), 0
            self._stages += 1
        begin, number = self._traversed, len(self._left)
        step = self._scan(work, begin) / max(1, work.cells)
        at, tests, patch = begin, work.tests.tolist(), 0
        for cell in range(work.cells):
            at += step
            if number + cell >= CELLS:
                at = max(at, self._left[number + cell - CELLS])
            self._entered = max(self._entered, at)
            end = round((cell + 1) * len(tests) / work.cells)
            for count in tests[patch:end]:
                self._test(count)
            patch = end
            self._left.append(self._entered)
        self._traversed = max(begin + step * max(1, work.cells), at)

    def _scan(self, work, begin):
        """Cycles of traversal for a stage that begins then."""
        # A group that lives is looked up first, then each of its rays.
        lookups = work.grid_rays * (1 + 1 / GROUP)
        least = max(work.rows, lookups, work.passes / self._pipelines, work.cells)
        ended = np.searchsorted(self._ends, begin, side="right") / max(1, len(self._ends))
        return least + ended * max(0, work.words - least)

    def _test(self, count):
        """A patch with so many tests."""
        slots = self._config.icu.slots
        enters = self._entered if len(self._ends) < slots else max(self._entered, self._ends[-slots])
        self._entered = enters + self._fetch
        self._tested = max(enters + SETUP, self._tested) + max(1, count)
        self._ends.append(self._tested)
