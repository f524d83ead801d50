"""A grid of cells, and the grid rays of a frustum, as fields of a stimulus."""

from collections.abc import Callable

import numpy as np

from golden.engine.config import Config
from golden.engine.ctu.grid_rays import GridRays
from golden.engine.ctu.unit import CellTraversalUnit
from golden.engine.frustum import FrustumRecord
from golden.engine.lib.fixed import signed, unsigned
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.stimulus.block import Arrays, Field
from golden.engine.stimulus.patches import scene_patches

__all__ = ["CELL_NUMBER", "SHELL", "grid_fields", "masks", "random_table", "shells", "table_of"]

SHELL = unsigned(10, 0)
CELL_NUMBER = signed(24, 0)
# Number of patches in the grid, and the shells of the stimulus.
PATCHES, SHELLS = 200, (2, 9)


def grid_fields(config: Config) -> list[Field]:
    """Fields of `random_table`, the inputs of `table_of`."""
    return [Field("vertices", config.numbers.scene, "the patches of the scene, G coordinates", constant=True),
            Field("cell", unsigned(1, config.numbers.scene_bits), "side of a cell", constant=True)]


def random_table(random: np.random.Generator, origin: np.ndarray, config: Config) -> Arrays:
    """A scene around an origin, and a cell size."""
    vertices = scene_patches(random, PATCHES, origin, config.numbers)
    vertices = origin + ((vertices - origin) * random.uniform(0.2, 1)).astype(np.int64)
    longest = np.ptp(vertices.reshape(-1, 3), axis=0).max()
    return {"vertices": vertices, "cell": np.ceil(longest / random.integers(6, 14)).astype(np.int64)}


def table_of(given: Arrays) -> CellTable:
    """The cells of the scene."""
    return CellTable(given["vertices"], cell=int(given["cell"]))


def shells(record: FrustumRecord) -> Callable[[int], GridRays]:
    """A frustum's grid rays by shell; they do not depend on the cells."""
    table = CellTable(np.zeros((1, 4, 3), dtype=np.int64), cell=1 << 20)
    return CellTraversalUnit(record, table).rays


def masks(random: np.random.Generator, record: FrustumRecord, count: int) -> np.ndarray:
    """Masks of all rays, of a single ray, of clusters of rays, and of few rays."""
    shape = (record.rows, record.columns)
    drawn = np.zeros((count, *shape), dtype=np.int64)
    for number, mask in enumerate(drawn):
        if number % 4 == 0:
            mask[:] = 1
        elif number % 4 == 1:
            mask[random.integers(shape[0]), random.integers(shape[1])] = 1
        elif number % 4 == 2:
            row, column = random.integers(shape[0] // 2), random.integers(shape[1] // 2)
            mask[row:row + shape[0] // 4, column:column + shape[1] // 4] = 1
        else:
            mask[:] = random.random(shape) < 0.02
    return drawn
