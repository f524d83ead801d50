"""What the host gives an intersection unit for one frustum: its numbers and its tables, as stream payloads."""

import numpy as np

from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.frustum import FrustumRecord
from golden.engine.frustum.bundle import Bundle
from golden.engine.icu.sbb import SphericalWindows
from hw.icu.icu_formats import TableKind

__all__ = ["frustum_payload", "table_writes", "tiles"]


def tiles(sector: Sector, config: Config) -> tuple[int, int]:
    """Tiles across and down a section."""
    side = 1 << config.icu.tile_bits
    return -(-(sector.end_column - sector.first_column) // side), -(-(sector.end_row - sector.first_row) // side)


def frustum_payload(record: FrustumRecord, sector: Sector, config: Config) -> dict:
    """The value of `Formats.frustum`."""
    shadow = {"is_shadow": int(record.bundle == Bundle.SHADOW)} if config.icu.shadow_bits else {}
    return {
        "is_screen": int(record.is_screen), **shadow, "origin": record.origin.tolist(),
        "matrix": record.matrix.tolist(), "columns": record.columns, "rows": record.rows,
        "column_bits": record.column_bits, "row_bits": record.row_bits, "source": record.source,
        "longest_direction": 0 if record.is_screen else record.longest_direction,
        "section": {name: getattr(sector, name) for name in ("first_column", "end_column", "first_row", "end_row")},
        "tiles_across": tiles(sector, config)[0]}


def table_writes(record: FrustumRecord, config: Config, weights: np.ndarray | None = None) -> list[dict]:
    """The values of `IcuFormats.table_write`, in any order.

    Parameters
    ----------
    weights
        ``rows`` int64, of a ray of each row; without it no weight is written.
    """
    width = config.numbers.direction.width
    mask = (1 << width) - 1
    tables = [(TableKind.COLUMN, _pairs(record.column_table, width, mask)),
              (TableKind.ROW, _pairs(record.row_table, width, mask))]
    if not record.is_screen:
        tables.append((TableKind.SLACK, SphericalWindows(record, config).azimuth_slack.tolist()))
    if weights is not None:
        tables.append((TableKind.WEIGHT, weights.tolist()))
    return [{"kind": kind.value, "index": index, "data": data}
            for kind, table in tables for index, data in enumerate(table)]


def _pairs(table, width, mask):
    """Entries of a direction table as bits, the first number lowest."""
    first, second = (table[:, 0], table[:, 1]) if table.shape[1] == 2 else (table[:, 0], np.zeros(len(table), int))
    return [(int(a) & mask) | (int(b) & mask) << width for a, b in zip(first, second, strict=True)]
