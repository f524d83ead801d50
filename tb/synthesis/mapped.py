"""The netlist of a component for the ECP5, as it is placed, as Verilog that simulators take."""

import importlib.util
import re
from pathlib import Path

from hw.synthesis.flow import synthesise, yosys

__all__ = ["mapped_text"]

HARD = Path(__file__).with_name("cells.v")
# Yosys' own models, and the files that they are in.
SOFT = {"common_sim.vh": ("LUT2", "LUT4", "PFUMX", "L6MUX21", "TRELLIS_FF", "TRELLIS_DPR16X4"),
        "ccu2c_sim.vh": ("CCU2C",)}


def mapped_text(component, folder: Path) -> str:
    """The module ``top``, in which every cell has become what its model says; block RAMs and multipliers are modules.

    Parameters
    ----------
    folder
        For the netlist and the tool's logs.
    """
    synthesise(component, folder)
    (folder / "soft.v").write_text(_soft_cells())
    # The netlist has the cells' names as black boxes. Names would be most of the text.
    yosys(folder / "mapped.log", "read_json area.json", "delete =A:blackbox", "read_verilog soft.v",
          f"read_verilog -lib {HARD}", "hierarchy -check -top top", "proc",
          "setattr -mod -set keep_hierarchy 1 *TRELLIS_FF*", "flatten", "delete t:$scopeinfo",
          "memory_collect", "opt_expr", "rename -hide", "clean -purge", "rename -enumerate",
          "write_verilog -noattr mapped.v")
    return (folder / "mapped.v").read_text() + HARD.read_text()


def _soft_cells():
    """Without their delays."""
    share = Path(importlib.util.find_spec("pyosys").origin).parent / "share" / "ecp5"
    found = []
    for file, names in SOFT.items():
        text = re.sub(r"(?s)specify\n.*?endspecify", "", (share / file).read_text())
        found += [re.search(rf"(?ms)^module {name}\b.*?^endmodule\n", text)[0] for name in names]
    return "\n".join(found)
