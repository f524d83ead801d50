"""The page on the registers, from the tables that the hardware is made from."""

from hw.cluster import COUNTERS
from hw.registers.engine_registers import COUNTER_BITS, COUNTERS_BASE, ENGINE_REGISTERS
from hw.registers.error_code import error_table
from hw.registers.register import WORD_BYTES, register_table

__all__ = ["page"]

_PAGE = """\
# The registers

For whoever writes a driver: the registers behind the engine's AXI4-Lite port of 32 bits, the steps of a job, errors and
counters. `python -m hw registers -o docs/formats/registers.md` writes this page from
`hw/registers/engine_registers.py`, of which the hardware is made. Exported engines have the table in SystemRDL 2.0
(`radiosity_engine.rdl`), for tools such as [PeakRDL](https://peakrdl.readthedocs.io), and a driver in C.

Registers of 64 bits are at multiples of 8 and take two words. Write the low word first, then the high one: each takes
effect by itself, and the machine takes both over when it is idle. Answered with SLVERR, and without any effect, are an
access to an address without a register, a write to a read-only register, and a write of a value that the register must
not have: bits beyond those of the register are 0, and the meaning states further rules. Bytes without a strobe keep
their value, those of a command are 0; a write without strobes changes nothing and is no command. Further bits of a
command and of `interrupt` are ignored.

{registers}
## A job

1. Put an image ([the memory map](../memory-map.md)), the cells of shell 1 of each frustum and the descriptors
   ([the format of jobs](../job-format.md)) into main memory.
2. While the machine is idle write the addresses of the two rings, `ring_bits` and the windows. The windows contain both
   rings and everything that descriptors point to.
3. Write the number of descriptors ever submitted into `doorbell`. The first one is a load.
4. `completed` counts the completion records in their ring. Each one makes an interrupt pending, and so does a queue
   that halts. Acknowledge it before `completed` and `status` are read: no event is lost then.
5. Further descriptors go into the entries of those that have been taken, at any time, and then into `doorbell`.

A command that is not possible is an error and changes nothing. When a write of a command has been answered, `status`
shows its effect.

## Errors

An error of a descriptor is in its completion record, its results are undefined, and the queue goes on. The other errors
halt the queue: the first one stays in `error` until `command.clear`. [The engine](../engine.md) has the rules. A queue
that has halted is idle when `status.busy` is 0: no interrupt reports the end of a reset. Then write the address of an
image into `image`, and `command.resume`; or write `taken` into `doorbell` before, which drops the descriptors that are
left. After an error of a load, load all regions again (`status.loaded`). While `status.unwritten` is 1 `status.busy`
stays 1: write an address into `completions` that can be written, if the ring is the cause, then `command.resume`.

After `READ_TIMEOUT` all reads end as errors until all late beats have arrived: a load that begins before fails with
`READ_REPLY`. Repeat the load until it ends without an error. If a burst never ends, no load succeeds: reset the machine
and its memory together. After `WRITE_TIMEOUT` the same holds of writes and `WRITE_REPLY`.

The code of a load, of the ring or of a completion record that main memory has not served is that of the memory port's
first fault since the last load began, `command.clear` or a stop, whichever access had it; `READ_REPLY` or
`WRITE_REPLY` if there is none, or if it is of the other direction.

{errors}
## Counters

Words from {base:#x} on, {stride} bytes for each cluster; beyond the last one they read as 0. They count from the
beginning of the section, `memory_answered`, `memory_deferred` and `memory_stalls` since reset.

| offset | counter | counts |
|---|---|---|
{counters}
"""


def page() -> str:
    """The page as Markdown."""
    counters = "\n".join(f"| {WORD_BYTES * k:#04x} | `{name}` | {about} |"
                         for k, (name, about) in enumerate(COUNTERS.items()))
    return _PAGE.format(registers=register_table(ENGINE_REGISTERS), errors=error_table(), base=COUNTERS_BASE,
                        stride=WORD_BYTES << COUNTER_BITS, counters=counters)
