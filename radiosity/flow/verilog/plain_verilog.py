"""Verilog 2005 from the SystemVerilog that `radiosity.flow.verilog.export.verilog_of` writes."""

import re

__all__ = ["plain_verilog"]

_MODULE = re.compile(r"(?ms)^(module .*?\);\n)(.*?^endmodule\n)")
_BLOCK = re.compile(r"(?m)^  always_comb( begin)?\n((?:    .*\n)+)(?(1)  end\n)")
# A name that no signal has: those of Yosys have a dollar and a number, or none.
_START = "\\$start "


def plain_verilog(text: str) -> str:
    """The same modules with combinational logic that each dialect evaluates at time 0.

    An ``always @*`` waits for an event, and an initial value is one in Verilog 2005 alone. So all blocks of a module
    depend on a register that a nonblocking assignment changes at time 0, when they wait already. It decides about
    nothing: synthesis removes it, and Verilator makes the same model of both forms.

    Raises
    ------
    RuntimeError
        A block has a form that Yosys does not write.
    """
    text = _MODULE.sub(_started, text)
    if "always_comb" in text:
        raise RuntimeError("Yosys must write combinational blocks in the form that is known, and has not")
    return text


def _started(module):
    """A module whose blocks begin at time 0."""
    head, body = module.groups()
    body, blocks = _BLOCK.subn(lambda block: f"  always @* begin\n    if ({_START}) begin end\n{block[2]}  end\n", body)
    start = f"  reg {_START};\n  initial {_START}<= 1'b0;\n" if blocks else ""
    return f"{head}{start}{body}"
