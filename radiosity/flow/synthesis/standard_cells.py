"""From a component to its area and delay in the standard cells of a Liberty file: Yosys and its ABC, before layout."""

import json
import re
from dataclasses import dataclass
from pathlib import Path

from golden.base.errors import InputError
from radiosity.flow.synthesis.flow import pins_rtlil, yosys

__all__ = ["COUNTED", "CellArea", "map_to_cells"]

# A memory of more words is a macro, for which a Liberty file of standard cells has no cell.
_WORDS = 16
_ABC = ("strash;&get,-n;&fraig,-x;&put;scorr;dc2;dch,-f;map,-B,0.9;topo;buffer,-c;upsize;dnsize;stime,-p")
COUNTED = (f"Area: of the mapped cells, in the library's unit, registers and memories of at most {_WORDS} words among "
           "them. RAM bits: of the other memories, which are macros and have no area here. Delay: of the longest path "
           "of logic between registers, pins and memories, with sized and buffered cells, without wires, setup and "
           "clock-to-output times.")


@dataclass(frozen=True, kw_only=True)
class CellArea:
    """A component in standard cells.

    Parameters
    ----------
    area, register_area
        Of all cells and of the registers among them, in the unit of the Liberty file, usually square micrometres.
    cells, registers
        Their numbers.
    ram_bits
        Bits of the memories that are macros.
    delay
        Of the longest path of logic, in nanoseconds.
    """

    area: float
    register_area: float
    cells: int
    registers: int
    ram_bits: int
    delay: float


def map_to_cells(component, liberty: Path, folder: Path) -> CellArea:
    """Map a component alone to the cells of a Liberty file; its netlist and the tool's log stay in ``folder``.

    Initial values of registers are dropped: the reset sets those that need one.

    Raises
    ------
    InputError
        The file is not there, or the tool cannot map to its cells.
    """
    if not liberty.is_file():
        raise InputError(f"report: no Liberty file {liberty}")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "cells.il").write_text(pins_rtlil(component))
    log, library = folder / "cells.yosys.log", f'"{liberty.resolve()}"'
    no_initial_values = "setattr -unset init w:*"
    yosys(log, "read_rtlil cells.il", "hierarchy -top top", "proc", no_initial_values,
          "synth -flatten -booth -top top -run begin:fine", "memory_map -rom-only",
          f"memory_map t:$mem_v2 r:SIZE<={_WORDS} %i", no_initial_values, "opt_clean", "opt -fast -full", "opt -fast",
          "techmap", "opt -fast", f"dfflibmap -liberty {library}", "opt", f"abc -liberty {library} -script +{_ABC}",
          "opt_clean", "write_json cells.json", f"tee -q -o cells.stat stat -json -liberty {library}")
    delays = re.findall(r"ABC: WireLoad .* Delay = +([0-9.]+) ps", log.read_text(errors="replace"))
    found = json.loads((folder / "cells.stat").read_text())["design"]
    cells = {name: count for name, count in found["num_cells_by_type"].items() if not name.startswith("$")}
    registers = _registers(cells, liberty)
    if not delays and sum(cells.values()) > registers:
        raise InputError(f"report: ABC has stated no delay, see {log}")
    netlist = json.loads((folder / "cells.json").read_text())["modules"]["top"]["cells"].values()
    rams = [cell["parameters"] for cell in netlist if cell["type"] == "$mem_v2"]
    return CellArea(area=float(found.get("area", 0)), register_area=float(found.get("sequential_area", 0)),
                    cells=sum(cells.values()), registers=registers,
                    ram_bits=sum(int(ram["SIZE"], 2) * int(ram["WIDTH"], 2) for ram in rams),
                    delay=float(delays[-1]) / 1000 if delays else 0.0)


def _registers(cells, liberty):
    """How many of the cells are flip-flops."""
    groups = re.split(r"\bcell\s*\(", liberty.read_text(errors="replace"))[1:]
    flops = {re.match(r'\s*"?([^")\s]+)', group)[1] for group in groups if re.search(r"\bff\s*\(", group)}
    return sum(count for name, count in cells.items() if name in flops)
