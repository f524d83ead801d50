"""Predicted cycles of the frusta of a phase: the cycle model for some of them, and means between these."""

from collections.abc import Sequence

import numpy as np

from golden.engine.cast.shelling import Shelling
from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord
from golden.engine.frustum.bundle import Bundle
from golden.engine.jobs.order import proximity_order
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.cycle_model import CycleModel, stage_work

__all__ = ["SAMPLES", "frustum_cycles"]

# Frusta that are predicted.
SAMPLES = 32


def frustum_cycles(records: Sequence[FrustumRecord], geometry: PatchGeometry, table: CellTable,
                   config: Config) -> np.ndarray:
    """The cycles of each frustum on one cluster; each ray of a shadow frustum's list takes one.

    `CycleModel` predicts `SAMPLES` frusta, evenly chosen from an order in which neighbours are near each other. The
    cycles of each other one are their mean, weighted by the inverse squares of the distances (D. Shepard, A
    two-dimensional interpolation function for irregularly-spaced data, 1968).

    Parameters
    ----------
    records, geometry, table
        The frusta of a phase, at least one, and patches and cells of the scene.
    config
        The machine's configuration.

    Returns
    -------
    M float64.
    """
    whole = config.for_rays(max(map(len, records)))
    shelling = Shelling.of_cells(geometry, table, whole, by_code=True)
    origins = np.array([record.origin for record in records], dtype=np.float64)
    even = np.linspace(0, len(records) - 1, min(SAMPLES, len(records))).round().astype(int)
    chosen = proximity_order(origins)[even]
    known = np.array([_predicted(records[number], shelling, config, whole) for number in chosen], dtype=np.float64)
    # At least a unit of G: a frustum at a sample's origin takes its cycles.
    away = np.maximum(1, np.square(origins[:, None] - origins[chosen]).sum(axis=2))
    return (known / away).sum(axis=1) / (1 / away).sum(axis=1)


def _predicted(record, shelling, config, whole):
    model = CycleModel(config, patches=len(shelling.geometry))
    for work in stage_work(shelling, record, whole):
        model.add(work)
    return model.cycles + (len(record.listed) if record.bundle == Bundle.SHADOW else 0)
