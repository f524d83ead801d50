"""Parameters of the memory system."""

from dataclasses import dataclass

from golden.base.errors import InputError
from golden.engine.config.checks import check_choice, check_power_of_two, check_range

__all__ = ["Memsys"]


@dataclass(frozen=True, kw_only=True)
class Memsys:
    """Parameters of the memory system.

    Parameters
    ----------
    cache_policy
        Placement and replacement of the caches unless a run chooses others: ``direct``, ``lru`` or ``lfu``, see
        `golden.engine.memsys.bus.cache`.
    cell_lines, patch_lines
        Lines of the cell cache and of the patch cache; a power of two, 8 to 4096. Hardware only.
    cache_ways
        Lines of a set under ``lru``; 2 or 4.
    lfu_lines
        Lines that ``lfu`` uses, at most; a power of two, 2 to 64. A lookup compares all of them in the same cycle.
    lfu_count_bits
        Bits of the counters of ``lfu``; 2 to 8.
    cache_generation_bits
        Bits of the generation tags that invalidate a cache in one cycle; after 2^b - 1 times its tags are cleared one
        by one; 1 to 8. Hardware only.
    cache_fetches
        Outstanding line fetches of a cache; a power of two, 1 to 16. Hardware only.
    scene_cells
        Cells of the largest scene; a power of two, 64 to 2^20. The cell filter has a bit for each. Hardware only.
    own_cells, own_entries
        Records of a cluster's cell address table and entries of its patch address table; powers of two, 16 to 2^20,
        ``own_cells`` at most ``scene_cells``. The bus serves all other cells. Hardware only.
    own_patches
        Patches of a cluster's resident set; a power of two, 16 to 8192.
    store_patches
        Patches that a cluster's patch store keeps of those that other clusters and main memory hold; a power of two, 2
        to 8192, or 0: there is no store. Hardware only.
    store_requests
        Requests for patches that the store may have in flight, and so readers that it can defer; a power of two, 2 to
        64. Hardware only.
    resident_set
        What a resident set holds where there are subshell lists (``ctu.subshell_bits`` above 0): ``found``, the patches
        that the low-density casting found; or ``filled``, other patches too up to its capacity. Elsewhere it has no
        effect: a set holds all patches, or a share of them dealt in turn.
    filter_generation_bits
        Bits of the generation tags that empty the filters in one cycle; after 2^b - 1 frusta they are cleared word by
        word; 1 to 8. Hardware only.
    reply_ids
        Patch ids in a reply to a request for a cell, and in a line of the cell cache; a power of two, 2 to 16. Longer
        lists take several replies. Hardware only.
    bus_requests
        Requests for cells, and for patches, that a cluster may have outstanding on the bus; a power of two, 1 to 16.
        Hardware only.
    """

    cache_policy: str = "lru"
    cell_lines: int = 256
    patch_lines: int = 256
    cache_ways: int = 4
    lfu_lines: int = 64
    lfu_count_bits: int = 6
    cache_generation_bits: int = 4
    cache_fetches: int = 8
    scene_cells: int = 1 << 16
    own_cells: int = 1 << 12
    own_entries: int = 1 << 14
    own_patches: int = 512
    store_patches: int = 128
    store_requests: int = 16
    resident_set: str = "filled"
    filter_generation_bits: int = 8
    reply_ids: int = 8
    bus_requests: int = 4

    def __post_init__(self):
        check_choice("memsys", "cache_policy", self.cache_policy, ("direct", "lru", "lfu"))
        check_choice("memsys", "resident_set", self.resident_set, ("found", "filled"))
        for name, low, high in (("cell_lines", 8, 4096), ("patch_lines", 8, 4096), ("cache_ways", 2, 4),
                                ("lfu_lines", 2, 64), ("cache_fetches", 1, 16), ("scene_cells", 64, 1 << 20),
                                ("own_cells", 16, 1 << 20), ("own_entries", 16, 1 << 20), ("own_patches", 16, 8192),
                                ("store_requests", 2, 64), ("reply_ids", 2, 16), ("bus_requests", 1, 16)):
            check_power_of_two("memsys", name, getattr(self, name), low, high)
        check_power_of_two("memsys", "store_patches", self.store_patches, 2, 8192, or_zero=True)
        for name, low, high in (("lfu_count_bits", 2, 8), ("cache_generation_bits", 1, 8),
                                ("filter_generation_bits", 1, 8)):
            check_range("memsys", name, getattr(self, name), low, high)
        if self.own_cells > self.scene_cells:
            raise InputError("configuration: Own cells (memsys.own_cells) must be at most memsys.scene_cells "
                             f"({self.scene_cells}), not {self.own_cells!r}")
