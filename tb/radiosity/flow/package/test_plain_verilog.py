"""Verilog 2005 of an exported core: the same logic as its SystemVerilog, in a form that each dialect starts."""

import re
import subprocess

import pytest

from radiosity.flow.verilog.plain_verilog import plain_verilog
from tb.lib.runner import tools
from tb.radiosity.flow.package.exported_engine import waiting

MODULE = ("module top(a, b, q);\n  input a;\n  wire a;\n  input b;\n  wire b;\n  output q;\n  reg q;\n"
          "  always_comb{0}endmodule\n")
BLOCKS = {"a choice": "\n    if (a) begin\n      q = b;\n    end\n",
          "statements": " begin\n    q = a;\n    if (b) begin\n      q = 1'h0;\n    end\n  end\n"}


def model(text, name, folder):
    """The C++ that Verilator makes of a module, by the names of its files."""
    source = folder / f"{name}.sv"
    source.write_text(text)
    with tools():
        subprocess.run(["verilator", "--cc", "-Wno-fatal", "-Wno-lint", "-O3", "--x-assign", "fast", "--x-initial",
                        "fast", "--prefix", "V", "--Mdir", folder / name, source], check=True, capture_output=True)
    return {path.name: path.read_text() for path in (folder / name).iterdir() if path.suffix in (".cpp", ".h")}


def test_verilator_makes_the_same_model_of_both_forms(router, tmp_path):
    """So neither is slower there, nor slower than Yosys' own form, whose blocks start alike."""
    files = router[1]
    first, second = (files[f"radiosity_router.{kind}"].decode() for kind in ("sv", "v"))
    assert not waiting(first)
    assert not waiting(second)
    blocks = second.count("always @*")
    assert blocks == first.count("always_comb") > 0
    assert model(first, "first", tmp_path) == model(second, "second", tmp_path)
    changed = re.sub(r"(always @\* begin\n(?:    .*\n)*?    .* = )(\w+);", r"\1~\2;", second, count=1)
    assert model(first, "first", tmp_path) != model(changed, "changed", tmp_path)


@pytest.mark.parametrize("kind", BLOCKS)
def test_each_block_depends_on_what_changes_at_time_0(kind):
    text = plain_verilog(MODULE.format(BLOCKS[kind]))
    assert not waiting(text)
    assert waiting(text.replace("if (\\$start ) begin end", ""))
    assert waiting(text.replace("<=", "="))


@pytest.mark.parametrize("block", [" q = a;\n", " begin\n    q = a;\n\n  end\n", "\n   q = a;\n"])
def test_a_block_of_another_form_is_refused(block):
    with pytest.raises(RuntimeError, match=r"^Yosys must write combinational blocks in the form that is known"):
        plain_verilog(MODULE.format(block))
