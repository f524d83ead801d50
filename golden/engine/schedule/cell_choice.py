"""Cell choice: the cell size with which the machine casts the frusta of a phase in the fewest cycles.

Hits are the same for every cell size; cycles are not. Small cells cost grid rays and words of survival, large ones
tests. The choice minimises predicted cycles, not efficiency, which larger cells raise by tests that hit nothing.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError
from golden.engine.config import Config
from golden.engine.ctu import margins
from golden.engine.ctu.unit import CellTraversalUnit
from golden.engine.frustum import FrustumRecord
from golden.engine.memory_map.layout import GRID_RAY_BITS, GRID_SHAPE_BITS, GRID_SIDE_BITS
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.cycle_model import CycleModel, stage_work
from golden.engine.schedule.job_shelling import job_shelling

__all__ = ["CELLS", "LIST_CELLS", "CellChoice", "choose_cell"]

# Candidates as shares of the scene's longest side; of machines with subshell lists those that the thesis measures.
CELLS = (0.25, 0.35, 0.18, 0.5, 0.125, 0.7, 0.09, 1.0, 0.0625)
LIST_CELLS = (0.5, 0.0625)


@dataclass(frozen=True, kw_only=True)
class CellChoice:
    """The chosen cell size.

    Parameters
    ----------
    cell
        Its share of the scene's longest side.
    cycles
        Predicted cycles of all frusta by cell size, of the candidates that fit into the machine. A prediction ends when
        it exceeds the least one before it.
    """

    cell: float
    cycles: dict[float, int]


def choose_cell(records: Sequence[FrustumRecord], geometry: PatchGeometry, config: Config, *,
                candidates: Iterable[float] | None = None) -> CellChoice:
    """The candidate with the least cycles that `CycleModel` predicts for frusta on one cluster.

    Parameters
    ----------
    records, geometry
        Some frusta of a phase, at least one, and the patches.
    config
        The machine's configuration.
    candidates
        Cell sizes. Default: `CELLS`, or `LIST_CELLS` where the machine has subshell lists.

    Raises
    ------
    InputError
        No candidate fits into the machine; the message is that of the largest.
    """
    if candidates is None:
        candidates = LIST_CELLS if config.ctu.subshells else CELLS
    # Capacities of rays are those of sections, which are cut later.
    whole = config.for_rays(max(map(len, records)))
    cycles, errors = {}, {}
    for cell in candidates:
        try:
            shelling = job_shelling(geometry, whole, cell=cell, by_code=True)
            for record in records:
                _check_capacities(record, shelling.table, config)
        except InputError as error:
            errors[cell] = error
            continue
        cycles[cell] = _predict(records, shelling, config, whole, most=min(cycles.values(), default=np.inf))
    if not cycles:
        raise errors[max(errors)]
    return CellChoice(cell=min(cycles, key=cycles.get), cycles=cycles)


def _predict(records, shelling, config, whole, *, most):
    """Cycles of the frusta, or of some of their stages once these exceed ``most``."""
    total = 0
    for record in records:
        model = CycleModel(config, patches=len(shelling.geometry))
        for work in stage_work(shelling, record, whole):
            model.add(work)
            if total + model.cycles > most:
                return total + model.cycles
        total += model.cycles
    return total


def _check_capacities(record, table, config):
    """Refuse cells that do not fit into the machine, whichever point of the scene a hemisphere starts from."""
    unit, ctu = CellTraversalUnit(record, table), config.ctu
    last = unit.last_shell
    if not record.is_screen:
        last = max(last, int(np.ceil(np.sqrt((table.shape * table.shape).sum())
                                     * (1 + margins.slack(1, rounding=unit.rounding)))))
    shells = [unit.rays(shell) for shell in range(2, last + 1)]
    near = unit.open(1, np.ones((record.rows, record.columns), dtype=bool))
    for what, value, most in (
            ("cells", len(table), config.memsys.scene_cells),
            ("cells along an axis", int(table.shape.max()), (1 << GRID_SHAPE_BITS) - 1),
            ("cells of shell 1", len(near), 1 << ctu.near_cell_bits), ("shells", last + 1, 1 << ctu.shell_bits),
            ("rows of grid rays", sum(one.rows for one in shells), 1 << ctu.grid_row_bits),
            ("columns of grid rays", sum(one.columns for one in shells), 1 << ctu.grid_column_bits),
            ("rows of a shell", max((one.rows for one in shells), default=0), (1 << GRID_SIDE_BITS) - 1),
            ("columns of a shell", max((one.columns for one in shells), default=0), (1 << GRID_SIDE_BITS) - 1),
            ("grid rays", sum(one.rows * one.columns for one in shells), 1 << GRID_RAY_BITS)):
        if value > most:
            raise InputError(f"cells: {what.capitalize()} must be at most {most}, not {value}; use larger cells")
