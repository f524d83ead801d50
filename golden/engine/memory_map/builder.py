"""The memory image of a scene and a phase."""

from collections.abc import Sequence

import numpy as np

from golden.base.errors import InputError
from golden.engine.config import Config
from golden.engine.ctu.unit import CellTraversalUnit
from golden.engine.frustum import FrustumRecord
from golden.engine.memory_map.check import check_image
from golden.engine.memory_map.image import MemoryImage
from golden.engine.memory_map.image_layout import region_records
from golden.engine.memory_map.layout import EVERY_CLUSTER, REGIONS
from golden.engine.memory_map.tables import grid_tables, list_tables, ray_tables, scene_tables
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.phase import Schedule
from golden.engine.schedule.resident_sets import spread_sets
from golden.engine.schedule.subshells import NO_SUBSHELLS

__all__ = ["phase_image"]

# What the tables and the results of a phase follow from.
_SHARED = ("bundle", "columns", "rows", "column_bits", "row_bits", "z_scale", "half_angles", "column_table",
           "row_table")


def phase_image(records: Sequence[FrustumRecord], geometry: PatchGeometry, table: CellTable, config: Config, *,
                weights: np.ndarray | None = None, plan: Schedule | None = None) -> MemoryImage:
    """The image of a phase: grid rays for as many shells as its farthest frustum needs.

    Parameters
    ----------
    records
        The frusta of the phase: other origins and axes, but the same rays.
    geometry, table
        Patches and cells of the scene.
    config
        The machine's configuration.
    weights
        ``rows`` int64, form factor of one ray of each row in units of 2^-W (`Hemisphere.polar_weights`); 0 by default.
    plan
        The schedule whose resident sets and subshell lists the clusters hold. Default: every cluster holds all patches
        if they fit (``memsys.own_patches``), and otherwise each node holds a share of them (`spread_sets`); there are
        no subshells.

    Raises
    ------
    InputError
        The frusta have other rays than the first one or than the schedule, or the scene has more cells or grid rays
        than an image can hold.
    """
    _check_rays(records, plan)
    farthest = max((CellTraversalUnit(record, table) for record in records), key=lambda unit: unit.last_shell)
    patches, nodes = len(geometry), config.noc.nodes
    if plan is None:
        none = np.zeros(0, dtype=np.int64)
        if patches <= config.memsys.own_patches:
            cluster, address, held = EVERY_CLUSTER, np.arange(patches), (np.arange(patches), *[none] * (nodes - 1))
        else:
            sets = spread_sets(patches, clusters=nodes, capacity=config.memsys.own_patches)
            (cluster, address), held = sets.residence(patches), sets.patches
        lists, processor = (held, (NO_SUBSHELLS,) * nodes), np.arange(nodes)
    else:
        cluster, address = plan.sets.residence(patches)
        lists, processor = (plan.sets.patches, plan.subshells), plan.processor
    regions = {
        **scene_tables(geometry, table), **list_tables(*lists, processor=processor),
        "residence": region_records("residence", patches, cluster=cluster, address=address),
        **ray_tables(records[0], config, weights), **grid_tables(farthest, config)}
    image = MemoryImage({region.name: regions[region.name] for region in REGIONS})
    check_image(image)
    return image


def _check_rays(records, plan):
    first, *others = records
    if plan is not None and (first.columns, first.rows) != (plan.partition.columns, plan.partition.rows):
        raise InputError(f"memory image: Frusta must have the schedule's {plan.partition.columns} x "
                         f"{plan.partition.rows} rays, not {first.columns} x {first.rows}")
    for number, record in enumerate(others, start=1):
        if not all(np.array_equal(getattr(record, name), getattr(first, name)) for name in _SHARED):
            raise InputError(f"memory image: Frusta of a phase must have the same rays; frustum {number} has others")
