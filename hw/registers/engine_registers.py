"""The engine's registers."""

from golden.memory_map import REGIONS
from hw.registers.error_code import CODE_BITS
from hw.registers.register import Access, Field, Register

__all__ = ["ADDRESS_BITS", "COUNTERS_BASE", "COUNTER_BITS", "ENGINE_REGISTERS", "MAGIC", "VERSION", "register"]

MAGIC = int.from_bytes(b"RADE", "little")
VERSION = 1
# Of the address of a byte; counters are in the upper half, so many of each cluster at most.
ADDRESS_BITS, COUNTER_BITS = 15, 6
COUNTERS_BASE = 1 << ADDRESS_BITS - 1


def _flag(name, about):
    return Field(name=name, width=1, about=about)


ENGINE_REGISTERS = (
    Register(name="magic", access=Access.READ, about=f"{MAGIC:#x}."),
    Register(name="version", access=Access.READ, about=f"Of the registers: {VERSION}."),
    Register(name="clusters", access=Access.READ, about="How many."),
    Register(name="command", access=Access.COMMAND, width=5, about="What to do. Of several bits the first one counts.",
             fields=(
        _flag("stop", "ends all that is under way, and what was loaded is lost"),
        _flag("clear", "forgets the error"),
        _flag("load", "reads `regions` of the image at `image`"),
        _flag("cast", "casts the frustum that was loaded last"),
        _flag("write", "writes `results` to the image"))),
    Register(name="status", access=Access.READ, width=8, about="What goes on.", fields=(
        _flag("loads", "tables are being read"),
        _flag("casts", "a frustum is under way"),
        _flag("writes", "results are being written"),
        _flag("stops", "something is being ended"),
        _flag("loaded", "all regions have been loaded, and without an error since then"),
        _flag("failed", "`error` is not 0"),
        _flag("present", "there is a frustum that has been begun"),
        _flag("earlier", "and one before it"))),
    Register(name="error", access=Access.READ, width=CODE_BITS, about="What went wrong first, see below."),
    Register(name="error_cluster", access=Access.READ, about="With which cluster, if it was one."),
    Register(name="error_address", access=Access.READ, width=64,
             about="With which byte of memory, or of which cell or patch the number."),
    Register(name="regions", access=Access.WRITE, width=len(REGIONS), about="Regions to read, a bit each in the order "
             "of the memory map; not `residents`, of which the patches are read, and those that the machine writes."),
    Register(name="image", access=Access.WRITE, width=64, about="Address of the image, a multiple of 64."),
    Register(name="read_base", access=Access.WRITE, width=64, about="First byte that may be read. Of this and the next "
             "one: not while anything goes on."),
    Register(name="read_limit", access=Access.WRITE, width=64, about="The byte after the last one."),
    Register(name="write_base", access=Access.WRITE, width=64, about="First byte that may be written. Of this and the "
             "next one: not while results are written."),
    Register(name="write_limit", access=Access.WRITE, width=64, about="The byte after the last one."),
    Register(name="total", access=Access.WRITE, width=64, about="What the weights of all rays of a frustum add up to."),
    Register(name="results", access=Access.WRITE, width=3, about="What is written.", fields=(
        _flag("hits", "the hits"),
        _flag("sums", "the sums of all frusta since they were written last; hits are gone through in any case"),
        _flag("earlier", "those of the frustum before the present one, which may be under way"))),
    Register(name="policy", access=Access.WRITE, width=2, about="Of the caches: 0 direct mapped, 1 LRU, 2 LFU. Taken "
             "when cells are loaded, which also empties them.", reset=1),
    Register(name="watchdog", access=Access.WRITE, about="Cycles that a command may take; 0: no limit.", reset=1 << 26),
    Register(name="cycles", access=Access.READ, about="Of the present frustum, or the last one."),
    Register(name="flits", access=Access.READ, about="That the network's routers have sent since it was reset."),
    Register(name="flit_stalls", access=Access.READ, about="Cycles, over all ports of routers, in which flits waited."),
    Register(name="cell_hits", access=Access.READ, about="Of the cell cache since it was emptied."),
    Register(name="cell_misses", access=Access.READ, about="The same."),
    Register(name="patch_hits", access=Access.READ, about="Of the patch cache."),
    Register(name="patch_misses", access=Access.READ, about="The same."),
)


def register(name: str) -> Register:
    """One of them."""
    return next(one for one in ENGINE_REGISTERS if one.name == name)
