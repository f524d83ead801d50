"""Verilog of components."""

import os
import re
from contextlib import contextmanager
from itertools import groupby

from amaranth.back import rtlil, verilog
from amaranth.hdl import Elaboratable
from amaranth.lib import wiring

from hw.lib.black_box import flatten

__all__ = ["verilog_of"]

# Words of a memory that begin with the same value become a loop if there are more of them.
_FEW = 8


def verilog_of(component: wiring.Component, name: str) -> str:
    """A component as the module ``name``, its ports by the names of its members."""
    os.environ["AMARANTH_USE_YOSYS"] = "builtin"
    with _unwritten_zeros():
        text = verilog.convert(_Flat(component), name=name, emit_src=False, strip_internal_attrs=True)
    # A wire of no bits, which nothing uses, would be written as one of two.
    text = re.sub(r"(?m)^ *(?:wire|reg) \[-1:0\] .*\n", "", text)
    return _with_zeros(_with_loops(_with_constants(text)))


@contextmanager
def _unwritten_zeros():
    """Nothing is said of what a memory begins with if it is zeros: each of its bits would be an object of its own."""
    written = rtlil.ModuleEmitter.emit_memory

    def emit_memory(emitter, number, cell):
        if any(cell.init):
            written(emitter, number, cell)

    rtlil.ModuleEmitter.emit_memory = emit_memory
    try:
        yield
    finally:
        rtlil.ModuleEmitter.emit_memory = written


class _Flat(Elaboratable):
    """A component with the ports that its module shall have."""

    def __init__(self, component):
        self._component, members = component, {}
        for path, member, value in flatten(component):
            members[path] = member.flow(len(value))
            setattr(self, path, value)
        self.signature = wiring.Signature(members)

    def elaborate(self, platform):
        return self._component


def _with_constants(text):
    """A constant that is some bits of a signal beside others: what waits for nothing would never run.

    In a module with such the writer has a register that changes when time begins, for which all else waits.
    """
    always = re.compile(r"(?m)^  always @\*\n    (.* = \d+'\w+;)\n")
    begins = re.compile(r"(?m)^  reg (\S+dump_module\S+ ) = 0;$")
    modules = re.split(r"(?m)^(?=module )", text)
    for number, module in enumerate(modules):
        if always.search(module):
            wait = f"    if ({begins.search(module)[1]}) begin end"
            modules[number] = always.sub(lambda found, wait=wait: (
                f"  always @* begin\n{wait}\n    {found[1]}\n  end\n"), module)
    return "".join(modules)


def _with_loops(text):
    """Else most of the text would be a line for each word of a memory."""
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


def _with_zeros(text):
    """Memories of which nothing is said begin with zeros."""
    def begins(found):
        declared, width, memory, last = found.groups()
        label = f"\\zeros_{memory[1:]} " if memory.startswith("\\") else f"zeros_{memory}"
        return (f"{declared}  initial begin : {label}\n    integer k;\n"
                f"    for (k = 0; k <= {last}; k = k + 1) {memory} [k] = {int(width or 0) + 1}'h0;\n  end\n")

    return re.sub(r"(?m)^(  reg (?:\[(\d+):0\] )?(\S+) +\[(\d+):0\];\n)(?!  initial begin\n    (?:begin|\S+ ?\[))",
                  begins, text)
