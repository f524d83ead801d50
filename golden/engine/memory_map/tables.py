"""The tables of a scene and of a bundle of rays, as records of an image's layout."""

from collections.abc import Sequence

import numpy as np

from golden.engine.config import Config
from golden.engine.ctu.unit import CellTraversalUnit
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.sbb import SphericalWindows
from golden.engine.memory_map.beats import BEATS, pack_beats
from golden.engine.memory_map.image_layout import region_records
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.subshells import SubshellList

__all__ = ["grid_tables", "list_tables", "ray_tables", "scene_tables"]

Tables = dict[str, np.ndarray]


def scene_tables(geometry: PatchGeometry, table: CellTable) -> Tables:
    """Cells and patches."""
    low, high = pack_beats(geometry.vertices)
    patches = region_records("patches", len(geometry), id=np.arange(len(geometry)), surface=geometry.surface,
                             vertex=low)
    patches["top"][:, 1:BEATS] = high
    listed = table.patches.read(np.arange(len(table.patches)))
    return {"cell_grid": region_records("cell_grid", 1, lower=table.lower, cell=table.cell, shape=table.shape),
            "cells": region_records("cells", len(table), pointer=table.pointer, count=table.count),
            "patch_lists": region_records("patch_lists", len(listed), patch=listed), "patches": patches}


def list_tables(residents: Sequence[np.ndarray], subshells: Sequence[SubshellList], **fields) -> Tables:
    """Clusters, and the lists of their residents and subshells, cluster by cluster.

    Parameters
    ----------
    residents, subshells
        Of each cluster.
    fields
        The other fields of the clusters.
    """
    held, listed = [len(one) for one in residents], [len(one) for one in subshells]
    return {"clusters": region_records("clusters", len(residents), first_subshell=_starts(listed), subshells=listed,
                                       first_resident=_starts(held), residents=held, **fields),
            "subshells": region_records("subshells", sum(listed),
                                        patch=np.concatenate([one.patches for one in subshells]),
                                        shell=np.concatenate([one.shell for one in subshells])),
            "residents": region_records("residents", sum(held), patch=np.concatenate(residents))}


def ray_tables(record: FrustumRecord, config: Config, weights: np.ndarray | None) -> Tables:
    """Columns and rows of rays.

    Parameters
    ----------
    record
        A frustum of the rays.
    config
        The machine's configuration.
    weights
        ``rows`` int64, form factor of one ray of each row in units of 2^-W; 0 by default.
    """
    slack = 0 if record.is_screen else SphericalWindows(record, config).azimuth_slack
    return {"columns": region_records("columns", record.columns, table=_pairs(record.column_table)),
            "rows": region_records("rows", record.rows, table=_pairs(record.row_table),
                                   weight=0 if weights is None else weights, slack=slack)}


def grid_tables(unit: CellTraversalUnit, config: Config) -> Tables:
    """Grid rays of all shells up to the unit's last one."""
    shells = range(2, unit.last_shell + 1)
    rays = [unit.rays(shell) for shell in shells]
    rows, columns = [one.rows for one in rays], [one.columns for one in rays]

    def joined(name):
        return np.concatenate([getattr(one, name) for one in rays]) if rays else np.empty(0, dtype=np.int64)

    borders = np.array([unit.borders(shell) for shell in shells], dtype=np.int64).reshape(-1, 2)
    tables = [_pairs(joined(name)) for name in ("row_table", "column_table")]
    return {"shells": region_records("shells", len(shells), begin=borders[:, 0], end=borders[:, 1],
                                     threshold=[unit.threshold(shell, config) for shell in shells],
                                     row_border=[one.row_border for one in rays], first_row=_starts(rows), rows=rows,
                                     first_column=_starts(columns), columns=columns,
                                     first_ray=_starts(np.multiply(rows, columns))),
            "grid_rows": region_records("grid_rows", sum(rows), table=tables[0], position=joined("row_position"),
                                        first_near=joined("first_row"), near=joined("row_count"),
                                        column_reach=joined("column_reach"), column_border=joined("column_border")),
            "grid_columns": region_records("grid_columns", sum(columns), table=tables[1],
                                           position=joined("column_position"))}


def _pairs(table):
    """A table with a second column of 0 if it has only one."""
    return np.pad(table, ((0, 0), (0, 2 - table.shape[1]))) if table.size else np.zeros((0, 2), dtype=np.int64)


def _starts(counts):
    return np.cumsum([0, *counts])[:-1].astype(np.int64) if len(counts) else np.empty(0, dtype=np.int64)
