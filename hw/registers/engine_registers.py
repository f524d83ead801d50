"""The engine's registers, version 3: a queue of descriptors."""

from hw.memsys.bus.cache_policy import CachePolicy
from hw.registers.error_code import CODE_BITS
from hw.registers.register import Access, Field, Register

__all__ = ["ADDRESS_BITS", "COUNTERS_BASE", "COUNTER_BITS", "ENGINE_REGISTERS", "MAGIC", "RING_BITS", "VERSION",
           "register"]

MAGIC = int.from_bytes(b"RADE", "little")
VERSION = 3
# Bits of the address of a byte, and of the number of a counter of a cluster. Counters are in the upper half.
ADDRESS_BITS, COUNTER_BITS = 15, 6
COUNTERS_BASE = 1 << ADDRESS_BITS - 1
# Of the number of bits of a ring's numbers.
RING_BITS = 5
_TAKEN = "Taken over while nothing is in flight and `taken` equals `doorbell`, or the queue is halted."


def _flag(name, about, **given):
    return Field(name=name, width=1, about=about, **given)


ENGINE_REGISTERS = (
    Register(name="magic", access=Access.READ, about=f"{MAGIC:#x}."),
    Register(name="version", access=Access.READ, about=f"Of the registers: {VERSION}."),
    Register(name="clusters", access=Access.READ, about="Number of clusters."),
    Register(name="command", access=Access.COMMAND, width=4, about="Commands. Of several the lowest bit counts.",
             fields=(
        _flag("stop", "resets all units, aborts what is in flight and halts the queue; what was loaded is lost"),
        _flag("clear", "clears the error"),
        _flag("resume", "of a halted queue: loads all regions of the image at `image`, then the queue goes on"),
        _flag("copies", "no command: the load of `resume` gives the tables of cluster 0 to all clusters"))),
    Register(name="status", access=Access.READ, width=7, about="State of the machine.", fields=(
        _flag("busy", "a descriptor is in flight, or waits in a queue that is not halted"),
        _flag("loading", "tables are being read"),
        _flag("halted", "no descriptor is taken until `command.resume`"),
        _flag("stops", "units are in reset until main memory has answered"),
        _flag("loaded", "all regions have been loaded, without an error since"),
        _flag("failed", "`error` is not 0"),
        _flag("unwritten", "a completion record cannot be written; `command.resume` writes it again"))),
    Register(name="ring_bits", access=Access.WRITE, width=RING_BITS, about="The rings have 2^b entries each. Taken "
             "over with `ring`."),
    Register(name="ring", access=Access.WRITE, width=64, about=f"Address of the descriptors' ring. {_TAKEN}",
             is_address=True),
    Register(name="completions", access=Access.WRITE, width=64, about="Address of the completion records' ring. Taken "
             "over with `ring`.", is_address=True),
    Register(name="doorbell", access=Access.WRITE, about="Descriptors ever submitted, modulo 2^32. At most a ring more "
             "than `taken`, and than the completion records that the host has read."),
    Register(name="taken", access=Access.READ, about="Descriptors ever taken, modulo 2^32: their entries may be "
             "overwritten."),
    Register(name="completed", access=Access.READ, about="Completion records ever written, modulo 2^32."),
    Register(name="interrupt", access=Access.CONTROL, width=2, about="The pin `irq` is `enable` and `pending`.",
             fields=(
        _flag("enable", "written as it is"),
        _flag("pending", "set when `completed` advances and when the queue halts; cleared by writing 1",
              clears=True))),
    Register(name="image", access=Access.WRITE, width=64, about="Address of the image for `command.resume`.",
             is_address=True),
    Register(name="error", access=Access.READ, width=CODE_BITS, about="The first error of the machine itself, see "
             "below. Those of a descriptor are in its completion record."),
    Register(name="error_cluster", access=Access.READ, about="The cluster or patch node concerned, if any."),
    Register(name="error_address", access=Access.READ, width=64,
             about="The byte of memory, or the cell or patch concerned."),
    Register(name="read_base", access=Access.WRITE, width=64, about="First byte that may be read. This and the "
             "next three registers are taken over with `ring`."),
    Register(name="read_limit", access=Access.WRITE, width=64, about="The byte after the last one."),
    Register(name="write_base", access=Access.WRITE, width=64, about="First byte that may be written."),
    Register(name="write_limit", access=Access.WRITE, width=64, about="The byte after the last one."),
    Register(name="policy", access=Access.WRITE, width=2, about="Of the caches: 0 direct mapped, 1 LRU, 2 LFU. Taken "
             "when cells are loaded, which also empties them.", reset=1, most=max(one.value for one in CachePolicy)),
    Register(name="watchdog", access=Access.WRITE, about="Cycles that a load or a section may take, a section from "
             "its dispatch on or from the completion of its cluster's section before it, if later; "
             "0: no limit.", reset=1 << 26),
    Register(name="cycles", access=Access.READ, about="Cycles since reset, modulo 2^32."),
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
