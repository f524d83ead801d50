"""The cells that each stage may open, and must open, from the settle words that the unit has been given."""

from collections import Counter, defaultdict
from itertools import pairwise

import numpy as np

from golden.engine.ctu.settle_pyramid import SettlePyramid
from golden.engine.ctu.survival import survivors_by_code
from hw.ctu.stage_count import NEAR_STAGE
from hw.lib.payload import unpack
from tb.ctu.traversal_bench import STAGES, SWEEP, Surroundings

__all__ = ["StageCells", "in_order"]


class StageCells:
    """Bounds of what comes, stage by stage.

    A stage's grid rays are looked up behind the last cell of the stage that has to be over before it begins, and before
    the first cell of the stage that waits for it. Codes only grow, so rays that survive by the oldest codes of that
    time may open their cells, and rays that survive by the newest have to: what is between survives only because
    settles arrived later.

    Parameters
    ----------
    around
        The surroundings, when the frustum is over.
    stages
        Subshell, shell and window of each stage.
    """

    def __init__(self, around: Surroundings, stages):
        self._around, self._part, self._stages = around, around.part, stages
        self._config = around.part.config

    def check(self) -> tuple[int, int]:
        """Compare; the grid rays that the bounds leave open, and those that they exclude."""
        came, first, last = self._came()
        depth, excluded, undecided = self._config.ctu.run_ahead, 0, 0
        assert max(came, default=-1) < len(self._stages), "a stage came that is none of the frustum's"
        for number, (subshell, shell, window) in enumerate(self._stages):
            begins = max((last[one] for one in last if one < number - depth), default=0)
            ends = min((first[one] for one in first if one > number + depth), default=None)
            requested = self._part.numbers_of(shell, window)
            may, must = (self._surviving(shell, requested, codes) for codes in
                         (self._swept(begins if number > depth else 0), self._newest(ends)))
            self._compare(f"subshell {subshell}, shell {shell}", came[number], shell, may, must)
            excluded, undecided = excluded + len(requested) - len(may), undecided + len(may) - len(must)
        return undecided, excluded

    def _came(self):
        """Cells of each stage in their order, and the cycles of its first and its last one."""
        came, first, last, newest = defaultdict(list), {}, {}, -1
        for (cell, stage), cycle in zip(self._around.cells, self._around.cycles, strict=True):
            if stage == NEAR_STAGE and newest < 0:
                continue
            # Stages in flight are at most the run-ahead depth apart.
            oldest = max(newest - self._config.ctu.run_ahead, 0)
            number = oldest + (stage - oldest) % STAGES
            newest = max(newest, number)
            came[number].append(cell)
            first.setdefault(number, cycle)
            last[number] = cycle
        return came, first, last

    def _compare(self, what, came, shell, may, must):
        cells, got = self._part.cells(shell), Counter(came)
        most, least = (Counter(cell for ray in rays.tolist() for cell in cells[ray]) for rays in (may, must))
        assert got <= most, f"{what}: no grid ray that may survive meets {[*(got - most)][:5]}"
        if self._config.ctu.subshells:
            # An earlier subshell may have sent a ray, so no ray has to leave.
            return
        assert least <= got, f"{what}: {[*(least - got)][:5]} did not come"
        # A ray opens all of its cells or none.
        excess = got - least
        whole = [Counter(cells[ray]) for ray in np.setdiff1d(may, must).tolist()]
        explained = sum((one for one in whole if one <= excess), Counter())
        assert excess <= explained, f"{what}: {[*(excess - explained)][:5]} are a part of a grid ray's cells"
        for ray in must.tolist():
            assert in_order(cells[ray], came), f"{what}: the cells of grid ray {ray} came in another order"

    def _surviving(self, shell, requested, codes):
        """Those of the requested grid rays that survive by some codes; by None all do."""
        if codes is None:
            return requested
        part = self._part
        going = survivors_by_code(part.rays[shell], SettlePyramid(codes, self._config),
                                  part.traversal.threshold(shell, self._config), part.sector, part.record).ravel()
        return requested[going[requested]]

    def _swept(self, cycle):
        """The codes of the last whole sweep that the unit had to have taken up in a cycle; None before the first."""
        given = self._given()
        begins = [index for index, (_, tile, _) in enumerate(given) if tile == 0]
        whole = [(a, b) for a, b in pairwise(begins) if given[b][0] + SWEEP <= cycle]
        return self._codes(given[slice(*whole[-1])]) if whole else None

    def _newest(self, cycle):
        """The newest codes that the unit could know in a cycle; what it has not been given counts as unsettled."""
        return self._codes([one for one in self._given() if cycle is None or one[0] <= cycle])

    def _given(self):
        return [one for one in self._around.port.given if one[0] >= self._around.begun]

    def _codes(self, given):
        part, side = self._part, 1 << self._config.icu.tile_bits
        sector = part.sector
        codes = np.zeros((sector.end_row - sector.first_row, sector.end_column - sector.first_column), dtype=np.int64)
        for _, tile, word in given:
            row, column = (side * index for index in divmod(tile, part.tiles_across))
            place = codes[row:row + side, column:column + side]
            if place.size:
                place[:] = np.reshape(unpack(part.word, word), (side, side))[:place.shape[0], :place.shape[1]]
        return codes


def in_order(cells, came) -> bool:
    """Whether cells came one after the other, others between them."""
    rest = iter(came)
    return all(cell in rest for cell in cells)
