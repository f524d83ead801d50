"""Latencies and capacities of a cluster, from its components."""

from functools import cache

from golden.engine.config import Config
from hw.control.section_cast import SectionCast
from hw.ctu.ray_traversal import RayTraversal
from hw.ctu.stage_count import LATENCY
from hw.formats import VERTICES
from hw.icu.intersection_pipeline import IntersectionPipeline
from hw.icu.intersection_unit import IntersectionUnit
from hw.icu.patch_setup import PatchSetup
from hw.icu.ray_issue import RayIssue
from hw.icu.ray_list import RayList
from hw.icu.ray_memory import RayMemory
from hw.icu.settle_map import SettleMap
from hw.icu.window_walk import WindowWalk
from hw.memsys.memory_system import CELL_QUEUE, PATCH_QUEUE, REQUEST_QUEUE, MemorySystem
from radiosity.machines.engine.cluster_timing import ClusterTiming

__all__ = ["cluster_timing"]

# Of docstrings that have no attribute: `CtRayGenerator`'s latency without searches, `PositionSearch`'s cycles a bit,
# `RowPieces`' row, piece, and search without the bits.
_GENERATOR, _SEARCH, _ROW, _PIECE, _ARC = 28, 3, 1, 4, 3
# From the start of the memory system to the first near cell: measured, as `golden.engine.schedule.cycle_model` has it
# with the memory system's latency. `SectionCast`: from the last patch to the results.
_BEGIN, _END = 8, 3
# `IntersectionUnit`: from a frustum to its acceptance; of a shadow frustum, behind the last ray's code.
_ACCEPTED, _LISTED = 5, 1
# Cells in `CellTable` and in the buffer behind it.
_LISTS = 4
# Registers between the settle map's word and the mask of a tile's rays (`IcRayGenerator`).
_MASK = 2


@cache
def cluster_timing(config: Config) -> ClusterTiming:
    """The timing of a cluster of a configuration with one node."""
    setup, pipeline = PatchSetup(config=config), IntersectionPipeline(
        config=config, update_latency=RayMemory(config=config, tag=0).latency)
    traversal = RayTraversal(config=config, pipelines=config.ctu.traversal_pipelines(config.noc.clusters))
    icu = config.icu
    return ClusterTiming(
        begin=SectionCast.latency + _BEGIN,
        listing=RayList(config=config).latency - 1 + IntersectionUnit(config=config).listed + _LISTED - _ACCEPTED
        if icu.shadow_bits else 0,
        generator=_GENERATOR, search=_SEARCH, row=_ROW, piece=_PIECE, arc=_ARC,
        traversal=traversal.latency,
        sweep=(icu.side_bits - icu.tile_bits).bit_length() + 4 * icu.tile_bits + 7,
        memory=MemorySystem.latency, vertices=VERTICES, setup=setup.latency,
        walk=WindowWalk(config=config).latency + SettleMap(config=config, tag=1).latency + _MASK
        + RayIssue(config=config).latency,
        pipeline=pipeline.latency, over=LATENCY + 1, end=_END, cells=CELL_QUEUE,
        lists=_LISTS, entries=PATCH_QUEUE,
        requests=REQUEST_QUEUE, waiting=2 * REQUEST_QUEUE)
