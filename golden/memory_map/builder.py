"""The memory image of a scene, a phase and a frustum."""

import numpy as np

from golden.config import Config
from golden.ctu.unit import CellTraversalUnit
from golden.errors import InputError
from golden.frustum import FrustumRecord
from golden.icu.sbb import SphericalWindows
from golden.memory_map.beats import BEATS, pack_beats
from golden.memory_map.check import check_image
from golden.memory_map.image import MemoryImage
from golden.memory_map.layout import NONE, REGIONS
from golden.memory_map.records import frustum_fields, make_records
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
    regions = {**_scene_regions(geometry, table), **_phase_regions(plan, len(geometry)),
               **_frustum_regions(record, table, config, weights), **_shell_regions(record, table, config),
               "hits": _records("hits", len(record), patch=NONE), "sums": _records("sums", len(geometry) + 1)}
    image = MemoryImage({region.name: regions[region.name] for region in REGIONS})
    check_image(image)
    return image


def _scene_regions(geometry, table):
    low, high = pack_beats(geometry.vertices)
    top = np.zeros((len(geometry), 8), dtype=np.uint8)
    top[:, 1:BEATS] = high
    listed = table.patches.read(np.arange(len(table.patches)))
    return {"cell_grid": _records("cell_grid", 1, lower=table.lower, cell=table.cell, shape=table.shape),
            "cells": _records("cells", len(table), pointer=table.pointer, count=table.count),
            "patch_lists": _records("patch_lists", len(listed), patch=listed),
            "patches": _records("patches", len(geometry), id=np.arange(len(geometry)), surface=geometry.surface,
                                top=top, vertex=low)}


def _phase_regions(plan, patches):
    cluster, address = plan.sets.residence(patches)
    residents = [len(held) for held in plan.sets.patches]
    subshells = [len(listed) for listed in plan.subshells]
    borders = plan.partition.levels[-1]
    return {"residence": _records("residence", patches, cluster=cluster, address=address),
            "clusters": _records("clusters", len(borders), first_column=borders[:, 0], end_column=borders[:, 1],
                                 first_row=borders[:, 2], end_row=borders[:, 3], processor=plan.processor,
                                 first_subshell=_starts(subshells), subshells=subshells,
                                 first_resident=_starts(residents), residents=residents),
            "subshells": _records("subshells", sum(subshells),
                                  patch=np.concatenate([listed.patches for listed in plan.subshells]),
                                  shell=np.concatenate([listed.shell for listed in plan.subshells])),
            "residents": _records("residents", sum(residents), patch=plan.sets.chosen)}


def _frustum_regions(record, table, config, weights):
    is_screen = record.is_screen
    frustum = _records("frustum", 1, half_angles=record.half_angles, **frustum_fields(record, table))
    return {"frustum": frustum, "columns": _records("columns", record.columns, table=_pairs(record.column_table)),
            "rows": _records("rows", record.rows, table=_pairs(record.row_table),
                             weight=0 if weights is None else weights,
                             slack=0 if is_screen else SphericalWindows(record, config).azimuth_slack)}


def _shell_regions(record, table, config):
    unit = CellTraversalUnit(record, table)
    shells = range(2, unit.last_shell + 1)
    rays = [unit.rays(shell) for shell in shells]
    rows, columns = [one.rows for one in rays], [one.columns for one in rays]

    def joined(name):
        return np.concatenate([getattr(one, name) for one in rays]) if rays else np.empty(0, dtype=np.int64)

    borders = np.array([unit.borders(shell) for shell in shells], dtype=np.int64).reshape(-1, 2)
    cells = unit.open(1, np.ones((record.rows, record.columns), dtype=bool))
    tables = [_pairs(joined(name)) for name in ("row_table", "column_table")]
    return {"near_cells": _records("near_cells", len(cells), cell=cells),
            "shells": _records("shells", len(shells), begin=borders[:, 0], end=borders[:, 1],
                               threshold=[unit.threshold(shell, config) for shell in shells],
                               row_border=[one.row_border for one in rays], first_row=_starts(rows), rows=rows,
                               first_column=_starts(columns), columns=columns,
                               first_ray=_starts(np.multiply(rows, columns))),
            "grid_rows": _records("grid_rows", sum(rows), table=tables[0], position=joined("row_position"),
                                  first_near=joined("first_row"), near=joined("row_count"),
                                  column_reach=joined("column_reach"), column_border=joined("column_border")),
            "grid_columns": _records("grid_columns", sum(columns), table=tables[1],
                                     position=joined("column_position"))}


def _pairs(table):
    """A table with a second column of 0 if it has only one."""
    return np.pad(table, ((0, 0), (0, 2 - table.shape[1]))) if table.size else np.zeros((0, 2), dtype=np.int64)


def _starts(counts):
    return np.cumsum([0, *counts])[:-1].astype(np.int64) if len(counts) else np.empty(0, dtype=np.int64)


def _records(region, length, **fields):
    """Records of a region with the fields given and 0 in all others."""
    return make_records(next(one for one in REGIONS if one.name == region), length, "memory image", fields)
