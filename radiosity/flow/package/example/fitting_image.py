"""The memory image of an example's frustum, if the unit has the capacities for it."""

import numpy as np

from golden.base.errors import InputError
from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord
from golden.engine.jobs.capacities import check_capacities
from golden.engine.jobs.descriptor import check_descriptor, frustum_descriptor
from golden.engine.memory_map import MemoryImage, phase_image
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.scene.patch_geometry import PatchGeometry

__all__ = ["fitting_image"]


def fitting_image(record: FrustumRecord, geometry: PatchGeometry, table: CellTable, config: Config, *,
                  weights: np.ndarray | None = None, own_patches: int | None = None, **results) -> MemoryImage:
    """The image of a frustum of which a cluster holds all cells.

    Parameters
    ----------
    record, geometry, table, config
        The frustum, patches and cells of its scene, and the configuration.
    weights
        Of the rays of each row.
    own_patches
        Patches that a cluster holds. Default: as many as it can.
    results
        Of its descriptor.

    Raises
    ------
    InputError
        The unit is too small, or has lists of subshells.
    """
    held = config if own_patches is None else config.replace({"memsys.own_patches": own_patches})
    image = phase_image([record], geometry, table, held, weights=weights)
    check_capacities(image, config)
    refusal = check_descriptor(frustum_descriptor(record, table, **results), config)
    memsys = config.memsys
    if config.ctu.subshells or len(image["cells"]) > memsys.own_cells or len(image["patch_lists"]) > memsys.own_entries:
        raise InputError("example: A cluster must hold the cells of a small scene, and no lists of subshells")
    if refusal:
        raise InputError(f"example: {refusal.reason}")
    return image
