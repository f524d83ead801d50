"""The memory map: every byte that passes between host and machine.

An image is a header, a table of regions, and the regions, each an array of equal records. `REGIONS` is the layout;
`MemoryImage.to_bytes` and `from_bytes` follow it, and docs/formats/images.md shows it. Fields are as wide as the
largest configuration needs, so one layout serves all configurations.

Integers are little-endian; signed ones are two's complement.
"""

from golden.engine.memory_map.beats import BEATS, COORDINATE_BITS, pack_beats, unpack_beats
from golden.engine.memory_map.builder import phase_image
from golden.engine.memory_map.image import MemoryImage, from_bytes
from golden.engine.memory_map.layout import (
    ALIGNMENT,
    ENTRY,
    EVERY_CLUSTER,
    GRID_POSITION_BITS,
    GRID_RAY_BITS,
    GRID_SHAPE_BITS,
    GRID_SIDE_BITS,
    HEADER,
    MAGIC,
    NONE,
    REGIONS,
    VERSION,
    WEIGHT_BITS,
    Field,
    Region,
)

__all__ = ["ALIGNMENT", "BEATS", "COORDINATE_BITS", "ENTRY", "EVERY_CLUSTER", "GRID_POSITION_BITS",
           "GRID_RAY_BITS", "GRID_SHAPE_BITS", "GRID_SIDE_BITS", "HEADER", "MAGIC", "NONE", "REGIONS", "VERSION",
           "WEIGHT_BITS", "Field", "MemoryImage", "Region", "from_bytes", "pack_beats", "phase_image", "unpack_beats"]
