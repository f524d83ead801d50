"""Mutants of a component: its Verilog with small faults, one of which a number selects when it runs."""

import re
import tempfile
from dataclasses import dataclass
from pathlib import Path

from hw.synthesis.flow import yosys

__all__ = ["SELECTOR", "Mutants", "make_mutants"]

SELECTOR = "mutant"


@dataclass(frozen=True)
class Mutants:
    """Small faults in one component.

    Parameters
    ----------
    text
        Verilog of a module ``top`` that holds them all; ``+mutant=K`` selects number K, from 1 on, and 0 none.
    about
        The fault of each, in Yosys' words.
    netlist, bits
        In Yosys' own format, with an input `SELECTOR` of so many bits that selects.
    """

    text: str
    about: tuple[str, ...]
    netlist: str
    bits: int


def make_mutants(text: str, *, count: int, seed: int) -> Mutants:
    """Draw mutants evenly from all faults of the connections of cells.

    Parameters
    ----------
    text
        Verilog with a module ``top``.
    count, seed
        How many, and which.
    """
    bits = (count + 1).bit_length()
    # Unused names are removed first: some of them disagree about a register's initial value.
    read = ["read_verilog -sv top.v", "hierarchy -top top", "proc", "flatten", "opt_clean -purge", "opt -full",
            "opt_clean -purge"]
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "top.v").write_text(text)
        # Initial values of memories must be constant, and a simulator must know the kinds of their read ports.
        yosys(folder / "list.log", *read, f"mutate -list {count} -seed {seed} -ctrl {SELECTOR} {bits} 1 -o mutants.ys "
              "t:* t:$meminit* %d t:$memrd* %d")
        commands = (folder / "mutants.ys").read_text().splitlines()
        # One file of commands: there may be thousands.
        yosys(folder / "make.log", *read, "script mutants.ys", "opt_clean", "write_rtlil mutants.il",
              "write_verilog -noattr mutants.v")
        made, netlist = (folder / "mutants.v").read_text(), (folder / "mutants.il").read_text()
    port = re.compile(rf"(?m)^  input \[{bits - 1}:0\] {SELECTOR};\n  wire \[{bits - 1}:0\] {SELECTOR};\n")
    selects = (f"  reg [{bits - 1}:0] {SELECTOR};\n"
               f'  initial if (!$value$plusargs("mutant=%d", {SELECTOR})) {SELECTOR} = 0;\n')
    made, found = port.subn(selects, made)
    if found != 1:
        raise ValueError(f"Selector ports must be one, not {found}")
    # No longer one of the ports.
    made = re.sub(rf"(?s)(module top\(.*?), {SELECTOR}\b(.*?\);)", r"\1\2", made, count=1)
    return Mutants(made, tuple(re.sub(rf" -ctrl {SELECTOR} \d+ \d+", "", line) for line in commands), netlist, bits)
