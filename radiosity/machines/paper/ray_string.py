"""Ray string: the references to patches of a casting that goes ray by ray through the cells."""

import numpy as np

from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.config import Config
from golden.engine.ctu.cell_traversal import NEVER, POSITION_FRACTION, Traversal
from golden.engine.ctu.grid_rays import FRACTION
from golden.engine.ctu.unit import global_directions
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.inverse_distance import decode
from golden.engine.memsys.patches.cell_table import CellTable

__all__ = ["ray_string"]

# Cells by which a ray continues beyond its hit. Positions are off by less (`golden.engine.ctu.margins`), and a ray that
# ended before its hit would not refer to the patch that it hits.
_BEHIND = 2.0**-10


def ray_string(record: FrustumRecord, hits: FixedHits, table: CellTable, config: Config) -> np.ndarray:
    """The patches in the order of reference: ray after ray, cell after cell, each patch once for a ray.

    A ray refers to all patches of the cells from the origin to that of its hit; without a hit, to the grid's border.

    Parameters
    ----------
    record, hits
        A hemisphere, and the hits of its rays.
    table, config
        The cells of the scene, and the configuration.

    Returns
    -------
    int64 patch numbers.

    Source: Shen & Deprettere, sections 1.3.3 and 1.4. They do not say in which order rays refer to patches.
    """
    origin = table.position(record.origin)
    direction = global_directions(record.all_directions(), record)
    last = _hit_cells(origin, direction, hits, table, config)
    traversal = Traversal(origin, direction, begin=0, end=NEVER, shape=table.shape)
    goes_on, rays, steps, cells = np.ones(len(record), dtype=bool), [], [], []
    while goes_on[traversal.ray].any():
        some = goes_on[traversal.ray] & traversal.inside
        rays.append(traversal.ray[some])
        steps.append(np.full(some.sum(), len(steps)))
        cells.append(table.number(traversal.index[some]))
        goes_on[traversal.ray[(traversal.index == last[traversal.ray]).all(axis=1)]] = False
        traversal.advance()
    rays, steps, cells = (np.concatenate(each or [np.empty(0, dtype=np.int64)]) for each in (rays, steps, cells))
    order = np.lexsort((steps, rays))
    rays, cells = rays[order], cells[order]
    ray, patch = np.repeat(rays, table.count[cells]), table.patches.read(table.entries(cells)).astype(np.int64)
    patches = int(patch.max(initial=0)) + 1
    return patch[np.sort(np.unique(ray * patches + patch, return_index=True)[1])]


def _hit_cells(origin, direction, hits, table, config):
    """The cell of each hit: R x 3 int64; -1 without one."""
    inverse = decode(hits.inverse, config.numbers)
    cells = np.divide(1, inverse, out=np.zeros(len(inverse)), where=inverse > 0) / config.numbers.scene.decode(
        np.array(table.cell)) + _BEHIND
    found = np.floor(origin * 2.0**-POSITION_FRACTION + direction * 2.0**-FRACTION * cells[:, None]).astype(np.int64)
    return np.where((inverse > 0)[:, None], found, -1)
