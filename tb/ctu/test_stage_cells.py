"""The bounds on the cells of each stage refuse what no schedule explains."""

from types import SimpleNamespace

import pytest

from golden.engine.stimulus.ctu.records import traversal_record
from hw.ctu.stage_count import NEAR_STAGE
from tb.ctu.stage_cells import StageCells
from tb.ctu.traversal_bench import SWEEP, ClusterPart
from tb.lib.configurations import config_of

# Cycles of a stage, in which the settle map is read twice.
STAGE = 10_000
CHANGES = {"ctu.subshell_bits": 0, "icu.rays": 1024, "icu.side_bits": 6}


class Played:
    """What a unit does that opens golden's cells in golden's order, with one map of settles per stage."""

    def __init__(self, run_ahead=2):
        config = config_of({**CHANGES, "ctu.run_ahead": run_ahead})
        record = traversal_record("lobby", cell=0.125, config=config)
        one, = record.sectors
        self.part = ClusterPart(record.shelling, record.record, one.sector, config)
        self.stages = [stage for stage in self.part.cluster.schedule(None, None) if stage[1] > 1]
        self.cells, self.begun, given = [(cell, NEAR_STAGE) for cell in one.played[0].stage.cells], 0, []
        self.cycles = [1] * len(self.cells)
        for number, played in enumerate(one.played[1:]):
            words = self.part.words(played.codes)
            given += [(number * STAGE + sweep * (len(words) + SWEEP) + tile, tile, word)
                      for sweep in range(3) for tile, word in enumerate(words)]
            came = played.stage.cells.tolist()
            self.cells += [(cell, number) for cell in came]
            self.cycles += range((number + 1) * STAGE - len(came), (number + 1) * STAGE)
        self.port = SimpleNamespace(given=given)
        self.last = number

    def check(self):
        return StageCells(self, self.stages).check()

    def of(self, number):
        """Indices of the cells of a stage."""
        return [index for index, (_, stage) in enumerate(self.cells) if stage == number]


def test_golden_is_within_its_own_bounds():
    undecided, excluded = Played().check()
    assert 100 < undecided < excluded


def test_without_run_ahead_the_settles_decide_every_grid_ray():
    undecided, excluded = Played(0).check()
    assert undecided == 0 < excluded


def excess(played):
    """A cell of a ray that settled two stages ago, once more in the last stage."""
    shell = played.stages[played.last][1]
    meets = {cell for cells in played.part.cells(shell) for cell in cells}
    opened = {played.cells[index][0] for index in played.of(played.last)}
    played.cells.append((min(meets - opened), played.last))
    played.cycles.append(played.cycles[-1])


def repeated(played):
    """One cell more often than there are rays that meet it."""
    index = played.of(0)[0]
    for _ in range(1 + sum(played.cells[index][0] in cells for cells in played.part.cells(played.stages[0][1]))):
        played.cells.insert(index, played.cells[index])
        played.cycles.insert(index, played.cycles[index])


def missing(played):
    index = played.of(0)[-1]
    del played.cells[index], played.cycles[index]


def moved(played):
    """A cell in the stage after its own."""
    index = played.of(0)[-1]
    played.cells[index] = played.cells[index][0], 1


def reversed_cells(played):
    indices = played.of(0)
    for index, cell in zip(indices, [played.cells[index] for index in reversed(indices)], strict=True):
        played.cells[index] = cell


@pytest.mark.parametrize("fault", [excess, repeated, missing, moved, reversed_cells], ids=lambda fault: fault.__name__)
def test_what_no_schedule_explains_is_refused(fault):
    played = Played()
    fault(played)
    with pytest.raises(AssertionError):
        played.check()
