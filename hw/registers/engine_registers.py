"""The engine's registers."""

from golden.memory_map import REGIONS
from hw.icu.icu_formats import WEIGHT_SUM_BITS
from hw.registers.error_code import CODE_BITS
from hw.registers.register import Access, Field, Register

__all__ = ["ADDRESS_BITS", "COUNTERS_BASE", "COUNTER_BITS", "ENGINE_REGISTERS", "MAGIC", "VERSION", "register"]

MAGIC = int.from_bytes(b"RADE", "little")
VERSION = 1
# Bits of the address of a byte, and of the number of a counter of a cluster. Counters are in the upper half.
ADDRESS_BITS, COUNTER_BITS = 15, 6
COUNTERS_BASE = 1 << ADDRESS_BITS - 1


def _flag(name, about):
    return Field(name=name, width=1, about=about)


ENGINE_REGISTERS = (
    Register(name="magic", access=Access.READ, about=f"{MAGIC:#x}."),
    Register(name="version", access=Access.READ, about=f"Of the registers: {VERSION}."),
    Register(name="clusters", access=Access.READ, about="Number of clusters."),
    Register(name="command", access=Access.COMMAND, width=5, about="Commands. Of several the lowest bit counts.",
             fields=(
        _flag("stop", "resets all units; what was loaded is lost"),
        _flag("clear", "clears the error"),
        _flag("load", "reads `regions` of the image at `image`"),
        _flag("cast", "casts the frustum that was loaded last"),
        _flag("write", "writes `results` to the image"))),
    Register(name="status", access=Access.READ, width=8, about="State of the machine.", fields=(
        _flag("loads", "tables are being read"),
        _flag("casts", "a frustum is being cast"),
        _flag("writes", "results are being written"),
        _flag("stops", "units are in reset until main memory has answered"),
        _flag("loaded", "all regions have been loaded, without an error since"),
        _flag("failed", "`error` is not 0"),
        _flag("present", "a frustum has been started"),
        _flag("earlier", "and one before it"))),
    Register(name="error", access=Access.READ, width=CODE_BITS, about="The first error, see below."),
    Register(name="error_cluster", access=Access.READ, about="The cluster concerned, if any."),
    Register(name="error_address", access=Access.READ, width=64,
             about="The byte of memory, or the cell or patch concerned."),
    Register(name="regions", access=Access.WRITE, width=len(REGIONS), about="Regions to read, a bit each in the order "
             "of the memory map; not `residents`, of which the patches are read, and those that the machine writes."),
    Register(name="image", access=Access.WRITE, width=64, about="Address of the image, a multiple of 64."),
    Register(name="read_base", access=Access.WRITE, width=64, about="First byte that may be read. This and the "
             "next register are taken when a load or a cast begins."),
    Register(name="read_limit", access=Access.WRITE, width=64, about="The byte after the last one."),
    Register(name="write_base", access=Access.WRITE, width=64, about="First byte that may be written. This and "
             "the next register are taken when results begin to be written."),
    Register(name="write_limit", access=Access.WRITE, width=64, about="The byte after the last one."),
    Register(name="total", access=Access.WRITE, width=WEIGHT_SUM_BITS, about="The sum of the weights of all rays "
             "since the sums were last written. The record after the last patch is this less all sums, modulo "
             f"2^{WEIGHT_SUM_BITS}."),
    Register(name="results", access=Access.WRITE, width=3, about="Results to write.", fields=(
        _flag("hits", "the hits"),
        _flag("sums", "the sums of all frusta since they were last written; hits are read out in any case"),
        _flag("earlier", "of the frustum before the present one, which may be cast meanwhile"))),
    Register(name="policy", access=Access.WRITE, width=2, about="Of the caches: 0 direct mapped, 1 LRU, 2 LFU. Taken "
             "when cells are loaded, which also empties them.", reset=1),
    Register(name="watchdog", access=Access.WRITE, about="Cycles that `status` may show activity since the "
             "last start; 0: no limit.", reset=1 << 26),
    Register(name="cycles", access=Access.READ, about="Cycles of the present frustum, or the last one."),
    Register(name="flits", access=Access.READ, about="Flits that the network's routers have sent since reset."),
    Register(name="flit_stalls", access=Access.READ, about="Cycles in which flits stalled, over all router ports."),
    Register(name="cell_hits", access=Access.READ, about="Hits of the cell cache since it was emptied."),
    Register(name="cell_misses", access=Access.READ, about="Its misses."),
    Register(name="patch_hits", access=Access.READ, about="Hits of the patch cache since it was emptied."),
    Register(name="patch_misses", access=Access.READ, about="Its misses."),
)


def register(name: str) -> Register:
    """One of them."""
    return next(one for one in ENGINE_REGISTERS if one.name == name)
