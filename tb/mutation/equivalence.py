"""Mutants that no testbench can kill, as they do what the component does."""

import re
import tempfile
from pathlib import Path

from golden.errors import InputError
from hw.synthesis.flow import yosys
from tb.mutation.mutants import SELECTOR, Mutants

__all__ = ["is_equivalent"]

# Of memories: they become registers for the proof.
MOST_BITS = 1 << 16
_SECONDS = 60
# How a proof ends that does not hold: a difference, no time left, or a register that only one of both has.
_UNPROVED = re.compile(
    r"ERROR: (Called with -verify and proof did (fail|time out)|No SAT model available for async FF)")


def is_equivalent(mutants: Mutants, mutant: int) -> bool:
    """Whether a mutant is proved to do in every cycle what the component does.

    Logic that no output depends on is removed from both. Then all outputs and all registers' next values must be the
    same, whatever the registers and the inputs are. So a mutant that differs only in unreachable states, or for which
    the proof takes too long, is not proved, and none of a component with large memories is.

    Parameters
    ----------
    mutants
        Of a component.
    mutant
        Its number.

    Raises
    ------
    InputError
        Yosys refuses a command.
    """
    memories = re.findall(r"(?m)^  memory width (\d+) size (\d+) ", mutants.netlist)
    if sum(int(width) * int(size) for width, size in memories) > MOST_BITS:
        return False
    chosen = (command for module, number in (("sound", 0), ("mutated", mutant)) for command in (
        f"delete -port {module}/w:{SELECTOR}", f"cd {module}",
        f"connect -set {SELECTOR} {mutants.bits}'d{number}", "cd .."))
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        (folder / "mutants.il").write_text(mutants.netlist)
        try:
            yosys(folder / "proof.log", "read_rtlil mutants.il", "setattr -unset init w:*", "memory_map", "opt_clean",
                  # Registers of one bit each, and before the copy, have equal names in both.
                  "dffunmap", "splitcells", "splitnets", "opt_clean",
                  "rename top sound", "copy sound mutated", *chosen, "opt_expr", "opt_muxtree", "opt_reduce", "wreduce",
                  "splitnets -ports", "opt_clean -purge", "opt_expr", "opt_merge",
                  "opt_clean -purge", "expose -shared -evert-dff sound mutated",
                  "miter -equiv -flatten sound mutated differs", "hierarchy -top differs", "opt_expr", "opt_merge",
                  "opt_clean", f"sat -verify -prove trigger 0 -timeout {_SECONDS} differs")
        except InputError:
            if not _UNPROVED.search((folder / "proof.log").read_text()):
                raise
            return False
    return True
