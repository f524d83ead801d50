"""Latencies of the paper's machine, from the engine's components of the same function."""

from functools import cache

from golden.engine.config import Config
from hw.ctu.ray_traversal import RayTraversal
from hw.formats import VERTICES
from hw.icu.intersection_pipeline import IntersectionPipeline
from hw.icu.patch_setup import PatchSetup
from hw.icu.ray_memory import RayMemory
from hw.memsys.bus.set_placement import SetPlacement
from hw.memsys.load.image_layout import PATCH_WORDS
from hw.memsys.patches.local_patch_geometry import LocalPatchGeometry
from radiosity.machines.paper.paper_timing import PaperTiming

__all__ = ["paper_timing"]

# `Cache`: behind the look-up of its placement, one for the answers and three for the record.
_ANSWER = 4
# `Router`: its cycles, and the link.
_LINK = 1
# Rays that the deferred-ray memory holds; the engine has none.
_DEFERRED = 1024


@cache
def paper_timing(config: Config, *, latency: int) -> PaperTiming:
    """The timing of the paper's machine with the components of a configuration.

    Parameters
    ----------
    config
        The configuration.
    latency
        Cycles of main memory.
    """
    return PaperTiming(
        traversal=RayTraversal(config=config, pipelines=1).latency,
        resident=LocalPatchGeometry(config=config).latency, cache=SetPlacement.latency + _ANSWER, vertices=VERTICES,
        setup=PatchSetup(config=config).latency,
        pipeline=IntersectionPipeline(config=config,
                                      update_latency=RayMemory(config=config, tag=0).latency).latency,
        words=PATCH_WORDS, switch=config.noc.router_cycles + _LINK, main=latency, requests=config.noc.requests,
        deferred=_DEFERRED)
