"""Which regions of an image a load reads."""

from golden.engine.memory_map.layout import REGIONS

__all__ = ["LOADED_REGIONS", "PHASE", "SCENE", "region_bits"]


def region_bits(*names: str) -> int:
    """The field `regions` of a load of the regions named."""
    order = [region.name for region in REGIONS]
    return sum(1 << order.index(name) for name in names)


# Of a load: the regions of the scene, and those of the phase, with the patches that its clusters hold. `residents` is
# not loaded: the load of `patches` reads it.
SCENE = region_bits("cell_grid", "cells", "patch_lists")
PHASE = region_bits(*(region.name for region in REGIONS
                      if region.name == "patches" or (region.life == "phase" and region.name != "residents")))
LOADED_REGIONS = SCENE | PHASE
