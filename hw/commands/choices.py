"""Names that options accept, without the modules that implement them: help must not import those.

A test compares every list with the registry that it names.
"""

__all__ = ["BLOCKS", "BOARD_NEXTPNR", "FAMILIES", "MHZ", "NEXTPNR", "POLICIES", "SOC_NEXTPNR", "TOPS"]

# `hw.report.UNITS`, `hw.package.tops.TOPS`, `hw.synthesis.family.FAMILIES`, `hw.memsys.cache_policy.CachePolicy`.
BLOCKS = ("icu", "ctu", "memsys", "control", "cluster", "engine", "registers", "noc")
TOPS = ("engine", "async_engine", "cluster", "icu", "ctu", "network", "router")
FAMILIES = ("ecp5", "xc7", "gowin", "ice40")
POLICIES = ("direct", "lru", "lfu")
# `hw.synthesis.flow.OPTIONS` and ``MHZ``.
NEXTPNR = "--placer-heap-timingweight 30"
MHZ = 105
# ``NEXTPNR`` of `hw.board.ulx3s` and `hw.board.soc`.
BOARD_NEXTPNR = "--placer static --no-tmdriv --router router2"
SOC_NEXTPNR = "--placer static --router router2"
