"""The memory image of a scene, a phase and a frustum."""

import numpy as np

from golden.config import Config
from golden.ctu.near_cells import near_cells
from golden.ctu.unit import CellTraversalUnit
from golden.errors import InputError
from golden.frustum import FrustumRecord
from golden.memory_map.check import check_image
from golden.memory_map.image import MemoryImage
from golden.memory_map.image_layout import IMAGE_LAYOUT
from golden.memory_map.layout import NONE, REGIONS
from golden.memory_map.records import frustum_fields
from golden.memory_map.tables import grid_tables, list_tables, ray_tables, scene_tables
from golden.memsys.cell_table import CellTable
from golden.scene.patch_geometry import PatchGeometry
from golden.schedule.phase import Schedule

__all__ = ["machine_image"]


def machine_image(record: FrustumRecord, geometry: PatchGeometry, table: CellTable, config: Config, plan: Schedule, *,
                  weights: np.ndarray | None = None) -> MemoryImage:
    """The memory image for one frustum of a phase: all that the machine reads, and empty records for its results.

    Parameters
    ----------
    record
        The frustum. It need not be the one that the phase was scheduled for, but has the same number of rays.
    geometry, table
        Patches and cells of the scene.
    config
        The machine's configuration.
    plan
        The schedule of the phase.
    weights
        ``rows`` int64, form factor of one ray of each row in units of 2^-W (`Hemisphere.polar_weights`); 0 by default.

    Raises
    ------
    InputError
        The schedule is for another number of rays, or the scene has more cells or grid rays than an image can hold.
    """
    if (record.columns, record.rows) != (plan.partition.columns, plan.partition.rows):
        raise InputError(f"memory image: Frustum must have the schedule's {plan.partition.columns} x "
                         f"{plan.partition.rows} rays, not {record.columns} x {record.rows}")
    unit, records, patches = CellTraversalUnit(record, table), IMAGE_LAYOUT.records, len(geometry)
    cells = near_cells(record, table, record.slopes)
    cluster, address = plan.sets.residence(patches)
    borders = plan.partition.levels[-1]
    regions = {
        **scene_tables(IMAGE_LAYOUT, geometry, table),
        **list_tables(IMAGE_LAYOUT, plan.sets.patches, plan.subshells, first_column=borders[:, 0],
                      end_column=borders[:, 1], first_row=borders[:, 2], end_row=borders[:, 3],
                      processor=plan.processor),
        "residence": records("residence", patches, cluster=cluster, address=address),
        "frustum": records("frustum", 1, half_angles=record.half_angles, **frustum_fields(record, table)),
        **ray_tables(IMAGE_LAYOUT, record, config, weights), **grid_tables(IMAGE_LAYOUT, unit, config),
        "near_cells": records("near_cells", len(cells), cell=cells),
        "hits": records("hits", len(record), patch=NONE), "sums": records("sums", patches + 1)}
    image = MemoryImage({region.name: regions[region.name] for region in REGIONS})
    check_image(image)
    return image
