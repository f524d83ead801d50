"""Directed scenes that separate the margins of shelling.

A closed box around the origin has a hole that lets one ray out (the shutter). A tiny patch sits on this ray where the
ray enters a cell, and a long sliver that starts in the origin's cell crosses the ray just behind the tiny patch. So
nothing but this ray keeps grid rays going, it has a hit from the first shell on, and only the right grid ray finds the
nearer one.
"""

import numpy as np

from golden.engine.ctu.cell_traversal import POSITION_FRACTION, Traversal
from golden.engine.ctu.grid_rays import FRACTION
from golden.engine.ctu.unit import CellTraversalUnit
from golden.engine.frustum import FrustumRecord
from golden.engine.memsys.patches.cell_table import CellTable
from golden.scene.scene import Scene
from tb.golden.cast.frusta import CELLS, room

__all__ = ["late_entries", "shuttered", "stays"]

# Distance of the tiny patch from its cell's border, and of the sliver behind it.
WITHIN, BEHIND = 0.01, 0.02


def shuttered(axes: np.ndarray, origin: np.ndarray, direction: np.ndarray, *, distance: float) -> Scene:
    """The scene for one ray.

    Parameters
    ----------
    axes
        3 x 3, the frustum's local axes as rows.
    origin, direction
        The ray (unit length).
    distance
        Where the tiny patch crosses the ray; the sliver does it `BEHIND` it.
    """
    height, hole = 0.05, 0.004
    local = axes @ direction
    across = local[:2] / local[2] * height
    size = 8 * height
    left, right, low, high = across[0] - hole * height, across[0] + hole * height, *(across[1] + np.array([-1, 1]) *
                                                                                   hole * height)

    def lid(x0, x1, y0, y1):
        return [(x0, y0, height), (x1, y0, height), (x1, y1, height), (x0, y1, height)]

    def wall(x0, y0, x1, y1):
        return [(x0, y0, -height), (x1, y1, -height), (x1, y1, height), (x0, y0, height)]

    patches = [lid(-size, left, -size, size), lid(right, size, -size, size),
               lid(left, right, -size, low), lid(left, right, high, size),
               wall(-size, -size, size, -size), wall(size, -size, size, size),
               wall(size, size, -size, size), wall(-size, size, -size, -size)]
    vertices = [np.array(patches) @ axes + origin]
    side = np.cross(direction, axes[0])
    side /= np.linalg.norm(side)
    other = np.cross(direction, side)
    square = np.array([-side - other, side - other, side + other, other - side])
    vertices.append((origin + distance * direction + WITHIN / 40 * square)[None])
    begin, end = origin + 0.12 * direction + 0.05 * other, origin + (distance + BEHIND) * direction
    end = end + 0.004 * (end - begin)
    vertices.append(np.array([begin - 0.002 * side, begin + 0.002 * side, end + 0.05 * side, end - 0.05 * side])[None])
    return room(np.concatenate(vertices))


def late_entries(record: FrustumRecord, table: CellTable, ray: int, *, shells: int = 9):
    """Where one ray enters cells that its own grid rays do not open in time to see a patch there.

    Grid rays survive for this ray only, until it has a hit just behind the entry.

    Yields
    ------
    Distances of the entries, in cells.
    """
    unit = CellTraversalUnit(record, table)
    alone = np.zeros((record.rows, record.columns), dtype=bool)
    alone.ravel()[ray] = True
    opened = {}
    for shell in range(1, shells + 1):
        for cell in unit.open(shell, alone).tolist():
            opened.setdefault(cell, shell)
    for cell, begin, end in stays(record, table, ray):
        distance = begin + WITHIN
        if begin < 1 or end < begin + 2 * WITHIN or distance > shells - 1.5:
            continue
        settled = [unit.settled(shell) * 2.0**record.numbers.scene_bits / table.cell for shell in range(1, shells + 1)]
        last = int(np.searchsorted(settled, distance + 2 * BEHIND))
        if opened.get(int(table.number(cell)), shells + 1) > last:
            yield distance


def stays(record, table, ray):
    """Cells along one ray with the distances at which it enters and leaves each."""
    along = record.all_directions()[ray] @ record.to_global.T / 2.0**(2 * FRACTION)
    walk = Traversal(table.position(record.origin), np.rint(along * 2.0**FRACTION).astype(np.int64)[None], begin=0,
                     end=4 * CELLS << POSITION_FRACTION, shape=table.shape)
    while len(walk.ray):
        low = table.lower + walk.index[0] * table.cell - record.origin
        with np.errstate(divide="ignore"):
            planes = np.sort(np.stack([low / along, (low + table.cell) / along]), axis=0) / table.cell
        yield walk.index[0].copy(), max(planes[0].max(), 0.0), planes[1].min()
        walk.advance()
