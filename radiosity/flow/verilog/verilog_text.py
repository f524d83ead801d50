"""Corrections of the Verilog that Yosys writes, each for a form that simulators get wrong or that wastes space.

Yosys has no options for them. All corrections match whole declarations or statements in the form of
``write_verilog``; `tb.radiosity.flow.package.test_export` simulates each of them.
"""

import re
from itertools import groupby

__all__ = ["add_zero_loops", "merge_equal_words", "remove_empty_wires", "wait_for_nothing", "without_ram_styles"]

# Words of a memory with the same initial value become a loop if there are more of them.
_FEW = 8
# Iterations of a loop: Quartus accepts 5,000 and Vivado 65,536.
_MOST = 1024


def remove_empty_wires(text: str) -> str:
    """Remove wires of no bits, which nothing uses: ``[-1:0]`` would declare two bits."""
    return re.sub(r"(?m)^ *(?:wire|reg) \[-1:0\] .*\n", "", text)


def wait_for_nothing(text: str) -> str:
    """Let combinational blocks be those of SystemVerilog, which run at time 0.

    An ``always @*`` waits for an event first. For Verilog 2005 Yosys writes a register that changes at time 0, on which
    each of them depends; in SystemVerilog its initial value is there before, and nothing ever runs.

    Raises
    ------
    RuntimeError
        A block has another form.
    """
    text = re.sub(r"(?m)^  reg \S+dump_module\S+ +(?:= 0)?;\n", "", text)
    text = re.sub(r"(?m)^    if \(\S+dump_module\S+ +\) begin end\n", "", text)
    text = re.sub(r"(?m)^  always @\*(?= begin$|$)", "  always_comb", text)
    if "@*" in text or "dump_module" in text:
        raise RuntimeError("Yosys must write combinational blocks in the form that is known, and has not")
    return text


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
        lines += [f"    begin : same_words_{blocks}",
                  *(f"      {line}" for line in _loops(memory, run[0][0] + ahead, run[-1][0] + ahead, value)),
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
        lines = _loops(f"{memory} ", 0, int(last), f"{int(width or 0) + 1}'h0")
        return f"{declared}  initial begin : {label}\n{''.join(f'    {line}{chr(10)}' for line in lines)}  end\n"

    text, done = re.subn(
        r"(?m)^(  reg (?:\[(\d+):0\] )?(\S+) +\[(\d+):0\];\n)(?!  initial begin\n    (?:begin|\S+ ?\[))", begins, text)
    if done != count:
        raise RuntimeError(f"{count} memories must be without initial values, not {done}")
    return text


def without_ram_styles(text: str) -> str:
    """Leave the kind of each memory to the tools: not all know the attribute, and those of other vendors refuse it."""
    return re.sub(r"(?m)^ *\(\* ram_style = \S+ \*\)\n", "", text)


def _loops(memory, first, last, value):
    """Statements that give words of a memory a value, in loops of at most `_MOST` iterations."""
    rows, rest = divmod(last + 1 - first, _MOST)
    if not rows:
        return ["integer k;", f"for (k = {first}; k <= {last}; k = k + 1) {memory}[k] = {value};"]
    lines = ["integer j, k;", f"for (j = 0; j < {rows}; j = j + 1)",
             f"  for (k = {first}; k <= {first + _MOST - 1}; k = k + 1) {memory}[{_MOST} * j + k] = {value};"]
    if rest:
        lines.append(f"for (k = {first + rows * _MOST}; k <= {last}; k = k + 1) {memory}[k] = {value};")
    return lines
