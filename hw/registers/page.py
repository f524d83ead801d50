"""The page on the registers, from the tables that the hardware is made from."""

from collections.abc import Mapping

from hw.registers.engine_registers import COUNTER_BITS, COUNTERS_BASE, ENGINE_REGISTERS
from hw.registers.error_code import error_table
from hw.registers.register import WORD_BYTES, register_table

__all__ = ["page"]

_PAGE = """\
# The registers

An AXI4-Lite port of 32 bits. This page is written by `python -m hw registers -o docs/registers.md`, from the table
that the hardware is made from (`hw/registers/engine_registers.py`); `hw/host.py` is a driver.

Registers of more than 32 bits take two words, the low one first. An access to an address without a register and a
write to a read-only register are answered with SLVERR and change nothing. Bytes without a strobe keep their value,
those of a command are 0.

{registers}
## A frustum

1. Put an image into main memory ([the memory map](memory-map.md)) and write its address and the windows.
2. `regions`, and `command.load`. What has been loaded stays, so a phase or a frustum needs its own regions only: a
   phase `residence`, `clusters`, `subshells` and `patches`, of which each cluster reads its own; a frustum those
   whose life is one, and `columns`, `rows`, `grid_rows` and `grid_columns` if its rays are others or its shells more.
3. `command.cast`.
4. `total`, `results`, `command.write`: the hits of each ray and the sums of each patch are in the image.

Results of a frustum may be written while the next one is cast (`results.earlier`); otherwise wait until `status` is
idle. A command that is not possible is an error and changes nothing.

## Errors

The first error stays in `error` until `command.clear`. After an error results are undefined. After a fault of the
tables, and after a reset by a stop or by an error, load all regions again (`status.loaded`).

After `READ_TIMEOUT` all reads end as errors until each late beat of before has come: a load that begins earlier fails
with `READ_REPLY`, whatever memory does now. Repeat the load until it ends without an error. If a burst never ends, none
does: reset the machine and its memory together. After `WRITE_TIMEOUT` the same holds of writes and `WRITE_REPLY`.

{errors}
## Counters

Words from {base:#x} on, {stride} bytes for each cluster; beyond the last one they read as 0. They count from the
beginning of the frustum, `memory_answered` and `memory_stalls` since reset.

| offset | counter | counts |
|---|---|---|
{counters}
"""


def page(counters: Mapping[str, str]) -> str:
    """The page as Markdown.

    Parameters
    ----------
    counters
        Names of the counters of a cluster in the order of their addresses, each with what it counts.
    """
    counters = "\n".join(f"| {WORD_BYTES * k:#04x} | `{name}` | {about} |"
                         for k, (name, about) in enumerate(counters.items()))
    return _PAGE.format(registers=register_table(ENGINE_REGISTERS), errors=error_table(), base=COUNTERS_BASE,
                        stride=WORD_BYTES << COUNTER_BITS, counters=counters)
