"""A netlist for the ECP5, as it is placed, cell by cell; an engine's is a machine for `SimulatedPort`."""

import json
import subprocess
from graphlib import TopologicalSorter
from pathlib import Path

import numpy as np

from golden.engine.config import Config
from radiosity.flow.simulator.machine_library import HARNESS

__all__ = ["HERE", "netlist_header", "netlist_library"]

HERE = Path(__file__).parent
# Cells that give what they are given in the same cycle: tables, choices, halves of adders, small memories.
TABLE, CHOICE, ADDER, READ = range(4)
MODES = {"NORMAL": 0, "WRITETHROUGH": 1, "READBEFOREWRITE": 2}


def netlist_header(netlist: Path, folder: Path) -> dict[str, dict]:
    """``Vtop.h`` in ``folder``, with a class as Verilator makes it, and the program that it carries out.

    Parameters
    ----------
    netlist
        As `radiosity.flow.synthesis.flow` leaves it.

    Returns
    -------
    dict
        The ports by name, as the netlist has them.

    Raises
    ------
    ValueError
        There is a cell of another kind, or one is set in another way than the models know.
    """
    folder.mkdir(parents=True, exist_ok=True)
    module = json.loads(netlist.read_text())["modules"]["top"]
    program = _Program(module["cells"])
    # Ports have locations too.
    (folder / "Vtop.h").write_text(_header(module["ports"], program, folder / "program"))
    (folder / "verilated.h").write_text("")
    program.words().tofile(folder / "program")
    return module["ports"]


def netlist_library(netlist: Path, config: Config, folder: Path) -> Path:
    """The library of an engine's netlist, made in ``folder``; see `netlist_header`."""
    netlist_header(netlist, folder)
    library = folder / "netlist.so"
    subprocess.run(["g++", "-std=c++17", "-shared", "-fPIC", "-O2", f"-I{folder}", f"-I{HERE}", "-DVM_TRACE=0",
                    f"-DBEAT_BYTES={config.memory.beat_bytes}", str(HARNESS), "-o", str(library)], check=True)
    return library


class _Program:
    """Locations of values, and cells in words of 32 bits: see netlist.h."""

    def __init__(self, cells):
        self._locations = {"0": 0, "1": 1, "x": 0}
        self._gates, self._registers, self._products, self._small, self._blocks = {}, [], [], [], []
        for cell in cells.values():
            kind = cell["type"]
            if kind == "$scopeinfo":
                continue
            if not hasattr(self, f"_add_{kind.lower()}"):
                raise ValueError(f"Cell must be one of those that are modelled, not {kind}")
            self._cell = cell
            getattr(self, f"_add_{kind.lower()}")()

    def locate(self, bit):
        """The location of a bit's value."""
        return self._locations.setdefault(bit, len(self._locations) - 1)

    def words(self):
        """The program."""
        driver = {location: number for number, gate in self._gates.items() for location in gate[7:9] if location > 1}
        order = TopologicalSorter({number: [driver[location] for location in gate[2:7] if location in driver]
                                   for number, gate in self._gates.items()}).static_order()
        parts = [[len(self._locations) - 1]]
        for kind in ([self._gates[number] for number in order], self._registers, self._products, self._small,
                     self._blocks):
            parts.append([len(kind)])
            parts += kind
        return np.array([word for part in parts for word in part], dtype=np.int64).astype(np.uint32)

    def _pin(self, name, number=0):
        bits = self._cell["connections"].get(name, ["0"])
        return self.locate(bits[number])

    def _pins(self, name, count):
        return [self._pin(f"{name}{k}") for k in range(count)]

    def _number(self, name):
        return int(self._cell["parameters"][name].replace("x", "0"), 2)

    def _must(self, **values):
        for name, allowed in values.items():
            value = self._cell["parameters"].get(name, allowed[0]).strip()
            if value not in allowed:
                raise ValueError(f"{name} of {self._cell['type']} must be {' or '.join(allowed)}, not {value}")
        return [self._cell["parameters"].get(name, allowed[0]).strip() for name, allowed in values.items()]

    def _add(self, kind, init, inputs, outputs):
        inputs, outputs = inputs + [0] * (5 - len(inputs)), outputs + [0] * (2 - len(outputs))
        nowhere = self.locate("nowhere")
        self._gates[len(self._gates)] = [kind, init, *inputs, *(location or nowhere for location in outputs)]

    def _add_lut4(self):
        self._add(TABLE, self._number("INIT"), [self._pin(name) for name in "ABCD"], [self._pin("Z")])

    def _add_dcca(self):
        # Always on where nothing is at its enable.
        if "CE" in self._cell["connections"]:
            raise ValueError("A clock buffer must have no enable")
        self._add(TABLE, 0xAAAA, [self._pin("CLKI")], [self._pin("CLKO")])

    def _add_pfumx(self):
        self._add(CHOICE, 0, [self._pin("BLUT"), self._pin("ALUT"), self._pin("C0")], [self._pin("Z")])

    def _add_l6mux21(self):
        self._add(CHOICE, 0, [self._pin("D0"), self._pin("D1"), self._pin("SD")], [self._pin("Z")])

    def _add_ccu2c(self):
        between = self.locate(object())
        for half, (carry_in, carry_out) in enumerate(((self._pin("CIN"), between), (between, self._pin("COUT")))):
            injects, = self._must(**{f"INJECT1_{half}": ("YES", "NO")})
            self._add(ADDER, self._number(f"INIT{half}") | (injects == "YES") << 16,
                      [*(self._pin(f"{name}{half}") for name in "ABCD"), carry_in],
                      [self._pin(f"S{half}"), carry_out])

    def _add_trellis_ff(self):
        has_enable, starts, *_ = self._must(CEMUX=("1", "CE", "INV"), REGSET=("RESET", "SET"), CLKMUX=("CLK",),
                                            LSRMUX=("LSR",), SRMODE=("LSR_OVER_CE",), LSRMODE=("LSR",))
        self._registers.append([self._pin("DI"), 1 if has_enable == "1" else self._pin("CE"),
                                int(has_enable == "INV"), self._pin("LSR"), self._pin("Q"), int(starts == "SET")])

    def _add_trellis_dpr16x4(self):
        self._must(WCKMUX=("WCK",), WREMUX=("WRE",))
        text = self._cell["parameters"]["INITVAL"].replace("x", "0")
        words = [int(text[first:first + 4], 2) for first in range(0, 64, 4)][::-1]
        for bit in range(4):
            self._add(READ, 4 * len(self._small) + bit, [self._pin("RAD", k) for k in range(4)], [self._pin("DO", bit)])
        self._small.append([*(self._pin("DI", k) for k in range(4)), *(self._pin("WAD", k) for k in range(4)),
                            self._pin("WRE"), *words])

    def _add_mult18x18d(self):
        holds_a, holds_b, *_ = self._must(
            REG_INPUTA_CLK=("NONE", "CLK0"), REG_INPUTB_CLK=("NONE", "CLK0"), REG_PIPELINE_CLK=("NONE",),
            REG_OUTPUT_CLK=("CLK0",), RESETMODE=("SYNC",))
        if holds_a != holds_b:
            raise ValueError("Operands must both be registered, or none")
        self._products.append([*self._pins("A", 18), *self._pins("B", 18), self._pin("SIGNEDA"), self._pin("SIGNEDB"),
                               self._pin("CE0"), self._pin("RST0"), int(holds_a == "CLK0"), *self._pins("P", 36)])

    def _add_dp16kd(self):
        block = []
        for port in "AB":
            holds, mode, *_ = self._must(**{
                f"REGMODE_{port}": ("NOREG", "OUTREG"), f"WRITEMODE_{port}": tuple(MODES),
                f"CSDECODE_{port}": ("0b000",), f"CLK{port}MUX": (f"CLK{port}",)})
            if any(self._pins(f"CS{port}", 3)) or self._pin(f"RST{port}"):
                raise ValueError("Select and reset of block RAMs must be 0")
            block += [self._number(f"DATA_WIDTH_{port}"), int(holds == "OUTREG"), MODES[mode],
                      *self._pins(f"DI{port}", 18), *self._pins(f"AD{port}", 14), self._pin(f"CE{port}"),
                      self._pin(f"OCE{port}"), self._pin(f"WE{port}"), self._pin(f"RST{port}"),
                      *self._pins(f"DO{port}", 18)]
        for number in range(64):
            words = self._number(f"INITVAL_{number:02X}")
            block += [words >> 20 * k & 0x3FFFF for k in range(16)]
        self._blocks.append(block)


def _header(ports, program, path):
    """`Vtop.h`: the class that Verilator would make."""
    members, inputs, outputs, tables = [], [], [], []
    for name, port in ports.items():
        width, member = len(port["bits"]), name.replace("__", "___05F")
        kind = next(kind for kind, most in (("CData", 8), ("SData", 16), ("IData", 32), ("QData", 64)) if width <= most)
        members.append(f"    {kind} {member} = 0;")
        locations = ", ".join(str(program.locate(bit)) for bit in port["bits"])
        tables.append(f"    const int32_t at_{name}[{width}] = {{{locations}}};")
        if port["direction"] == "output":
            outputs.append(f"        {member} = net.number(at_{name}, {width});")
        elif name != "clk":
            inputs.append(f"        net.give(at_{name}, {width}, {member});")
    return "\n".join([
        "#pragma once", '#include "netlist.h"', "struct Vtop {", *members, *tables, f'    Netlist net{{"{path}"}};',
        "    bool was = false;", "    explicit Vtop(VerilatedContext*) {}", "    void eval() {",
        *inputs, "        net.settle();", "        if (clk && !was) net.rise(), net.settle();", "        was = clk;",
        *outputs, "    }", "};", ""])
