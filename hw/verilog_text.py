"""Corrections of the Verilog that Yosys writes, each for a form that simulators get wrong or that wastes space.

Yosys has no options for them, and its passes that would avoid these forms turn case statements into chains of
multiplexers, which simulate slowly. All corrections match whole declarations or statements in the form of
``write_verilog``; `tb.package.test_export` simulates each of them.
"""

import re
from itertools import groupby

__all__ = ["add_zero_loops", "merge_equal_words", "remove_empty_wires", "trigger_constants"]

# Words of a memory with the same initial value become a loop if there are more of them.
_FEW = 8


def remove_empty_wires(text: str) -> str:
    """Remove wires of no bits, which nothing uses: ``[-1:0]`` would declare two bits."""
    return re.sub(r"(?m)^ *(?:wire|reg) \[-1:0\] .*\n", "", text)


def trigger_constants(text: str) -> str:
    """Let an ``always @*`` that assigns a constant run once: without an operand it would never run.

    Yosys gives a module with such blocks a register that changes at the start of simulation, and other blocks depend on
    it.

    Raises
    ------
    RuntimeError
        A module has no such register.
    """
    always = re.compile(r"(?m)^  always @\*\n    (.* = \d+'\w+;)\n")
    register = re.compile(r"(?m)^  reg (\S+dump_module\S+ ) = 0;$")
    modules = re.split(r"(?m)^(?=module )", text)
    for number, module in enumerate(modules):
        if always.search(module):
            trigger = register.search(module)
            if trigger is None:
                raise RuntimeError("Yosys must write a register that changes at the start of simulation, and has not")
            wait = f"    if ({trigger[1]}) begin end"
            modules[number] = always.sub(lambda found, wait=wait: (
                f"  always @* begin\n{wait}\n    {found[1]}\n  end\n"), module)
    return "".join(modules)


def merge_equal_words(text: str) -> str:
    """Initialise runs of equal words of a memory in loops: a line per word would be most of the text."""
    def same(numbered):
        number, line = numbered
        found = word.fullmatch(line)
        return found and (found[1], int(found[2]) - number, found[3])

    word = re.compile(r"    (\S+ ?)\[(\d+)\] = (\S+);")
    lines, blocks = [], 0
    for what, numbered in groupby(enumerate(text.splitlines()), key=same):
        run = list(numbered)
        if what is None or len(run) <= _FEW:
            lines += [line for _, line in run]
            continue
        memory, ahead, value = what
        lines += [f"    begin : same_words_{blocks}", "      integer k;",
                  f"      for (k = {run[0][0] + ahead}; k <= {run[-1][0] + ahead}; k = k + 1) {memory}[k] = {value};",
                  "    end"]
        blocks += 1
    return "\n".join(lines) + "\n"


def add_zero_loops(text: str, count: int) -> str:
    """Initialise each memory that has no initial values with zeros, in a loop.

    Raises
    ------
    RuntimeError
        They are not ``count``.
    """
    def begins(found):
        declared, width, memory, last = found.groups()
        label = f"\\zeros_{memory[1:]} " if memory.startswith("\\") else f"zeros_{memory}"
        return (f"{declared}  initial begin : {label}\n    integer k;\n"
                f"    for (k = 0; k <= {last}; k = k + 1) {memory} [k] = {int(width or 0) + 1}'h0;\n  end\n")

    text, done = re.subn(
        r"(?m)^(  reg (?:\[(\d+):0\] )?(\S+) +\[(\d+):0\];\n)(?!  initial begin\n    (?:begin|\S+ ?\[))", begins, text)
    if done != count:
        raise RuntimeError(f"{count} memories must be without initial values, not {done}")
    return text
