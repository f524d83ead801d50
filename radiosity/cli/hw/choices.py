"""Names that options accept, without the modules that implement them: help must not import those.

A test compares every list with the registry that it names.
"""

__all__ = ["BLOCKS", "BOARD_NEXTPNR", "FAMILIES", "MHZ", "NEXTPNR", "POLICIES", "SOC_NEXTPNR", "TOPS"]

# `radiosity.flow.synthesis.report.UNITS`, `radiosity.flow.package.tops.TOPS`,
# `radiosity.flow.synthesis.family.FAMILIES`, `hw.memsys.bus.cache_policy.CachePolicy`.
BLOCKS = ("icu", "ctu", "memsys", "control", "cluster", "engine", "registers", "noc")
TOPS = ("engine", "async_engine", "cluster", "icu", "ctu", "network", "router")
FAMILIES = ("ecp5", "xc7", "gowin", "ice40")
POLICIES = ("direct", "lru", "lfu")
# `radiosity.flow.synthesis.flow.OPTIONS` and ``MHZ``.
NEXTPNR = "--placer-heap-timingweight 30"
MHZ = 105
# ``NEXTPNR`` of `radiosity.flow.board.ulx3s` and `radiosity.flow.board.soc`.
BOARD_NEXTPNR = "--placer static --no-tmdriv --router router2"
SOC_NEXTPNR = "--placer static --router router2"
