"""Constraints of an exported core: its clocks, and what crosses between them."""

from collections.abc import Sequence
from itertools import permutations

from radiosity.flow.package.crossings import Crossing

__all__ = ["lpf", "sdc", "xdc"]


def xdc(clocks: Sequence[str], *, period: float, crossings: Sequence[Crossing]) -> str:
    """For Vivado.

    Parameters
    ----------
    clocks
        Ports.
    period
        In nanoseconds, of each clock.
    crossings
        Counters whose bits must arrive within a period.
    """
    return "".join([
        *_clocks(clocks, period),
        *(f"set_max_delay -datapath_only -from [get_clocks {source}] -to [get_clocks {sink}] {period:g}\n"
          for source, sink in permutations(clocks, 2)),
        *(f"set_bus_skew -from [get_cells {{{'/'.join((*one.path, one.source))}_reg[*]}}] "
          f"-to [get_cells {{{'/'.join((*one.path, one.sink))}_reg[*]}}] {period:g}\n" for one in crossings)])


def sdc(clocks: Sequence[str], *, period: float, crossings: Sequence[Crossing]) -> str:
    """For Quartus; other tools skip the bounds of skew, for which SDC has no command. Parameters as of `xdc`."""
    lines = _clocks(clocks, period)
    if len(clocks) > 1:
        lines.append(" ".join(["set_clock_groups -asynchronous", *(f"-group {{{clock}}}" for clock in clocks)]) + "\n")
    if crossings:
        lines.append("if {[llength [info commands set_max_skew]]} {\n")
        for one in crossings:
            source, sink = ("|".join(f"*{name}" for name in (*one.path, *register.split("/")))
                            for register in (one.source, one.sink))
            lines.append(f"  set_max_skew -from [get_registers {{{source}[*]}}] -to [get_registers {{{sink}[*]}}] "
                         f"{period:g}\n")
        lines.append("}\n")
    return "".join(lines)


def lpf(clocks: Sequence[str], *, period: float) -> str:
    """For nextpnr, which times no path between clocks."""
    return "".join(f'FREQUENCY PORT "{clock}" {1000 / period:g} MHZ;\n' for clock in clocks)


def _clocks(clocks, period):
    return [f"create_clock -name {clock} -period {period:g} [get_ports {clock}]\n" for clock in clocks]
