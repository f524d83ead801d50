"""The cells of shell 1, opened without grid rays.

Source: docs/exactness.md, Shelling.
"""

import numpy as np

from golden.engine.ctu import margins
from golden.engine.frustum import FrustumRecord
from golden.engine.memsys.patches.cell_table import CellTable

__all__ = ["near_cells"]


def near_cells(record: FrustumRecord, table: CellTable, slopes: tuple[float, float],
               rounding: tuple[float, float] = margins.DEFAULT) -> np.ndarray:
    """Numbers of the cells of shell 1, ascending.

    A hemisphere opens the origin's cell and its 26 neighbours. A screen opens the cells with their centre at depth 1
    or less that may meet the pyramid between the slopes, by `margins.rounding`.
    """
    home = (record.origin - table.lower) // table.cell
    if not record.is_screen:
        index = home + _cube(1)
    else:
        # Distance of the far corner of the cells that the pyramid may meet, in cells from the eye.
        reach = margins.DIAGONAL + (1 + margins.DIAGONAL) * np.sqrt(1 + np.square(slopes).sum())
        index = home + _cube(int(np.ceil(reach)))
        centre = (table.lower - record.origin) + table.cell * (index + 0.5)
        local = record.view_coordinates(centre) / table.cell
        near = margins.depth(1, rounding)
        inside = (local[:, 2] >= -near) & (local[:, 2] <= 1 + margins.slack(1, rounding=rounding))
        for axis, slope in enumerate(slopes):
            inside &= np.abs(local[:, axis]) <= slope * local[:, 2] + near * np.sqrt(1 + slope * slope)
        index = index[inside]
    index = index[((index >= 0) & (index < table.shape)).all(axis=1)]
    return np.sort(table.number(index))


def _cube(radius):
    return np.stack(np.meshgrid(*[np.arange(-radius, radius + 1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
