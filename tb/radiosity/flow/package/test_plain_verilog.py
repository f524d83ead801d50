"""Verilog 2005 of an exported core: the same logic as its SystemVerilog, in a form that waits for nothing."""

import re

import pytest

from golden.base.errors import InputError
from radiosity.flow.synthesis.flow import yosys
from radiosity.flow.verilog.plain_verilog import plain_verilog
from tb.radiosity.flow.package.exported_engine import waiting

# Statements of each kind, and the bits that they write: under conditions, of several signals, some of them twice.
BLOCKS = {
    "conditions": """\
    q = a;
    if (s[0]) begin
      q = b;
    end else if (s[1]) begin
    end else begin
      q = 4'h5;
    end
    if (s[2]) begin
      q = 4'd3;
    end
""",
    "cases": """\
    q = a;
    casez (s)
      3'h0, 3'h6:
          q = b;
      3'b1?1:
        begin
          q = 4'h9;
          if (a[1]) begin
            q[0] = b[3];
          end
        end
      3'h2:
          /* empty */;
      default:
          q = 4'h6;
    endcase
""",
    "cases of all values": """\
    (* full_case = 32'd1 *)
    casez (s[1:0])
      2'h0:
          q = a;
      2'h1:
          q = b;
      2'h?:
          q = 4'ha;
    endcase
""",
    "a wide selector": """\
    q = b;
    casez ({ s, a })
      7'h11:
          q = 4'h1;
      7'h12, 7'h54:
          q = a;
      default:
          q = { a[1:0], s[2], 1'h1 };
    endcase
""",
    "any digits of a wide selector": """\
    q = a;
    casez ({ s, a })
      7'b1???0?1, 7'b01?????:
          q = b;
      7'h?8:
          q = 4'h3;
      7'h??:
          q = { s, a[0] };
    endcase
""",
    "parts": """\
    { q[3], q[0] } = 2'h2;
    if (s[0]) begin
      q[0] = a[2];
    end
    q[2:1] = b[1:0];
""",
    "a value that stays twice": """\
    q = 4'h0;
    if (s[0]) begin
      q = a;
    end
    if (s[1]) begin
      if (s[2]) begin
        q = b;
      end
      if (a[0]) begin
        q[3:2] = 2'h1;
      end
    end
""",
    "no condition": """\
    q = 4'h0;
    q[2] = s[1];
""",
}


def module(block):
    return ("module top(a, b, s, q);\n  input [3:0] a;\n  wire [3:0] a;\n  input [3:0] b;\n  wire [3:0] b;\n"
            "  input [2:0] s;\n  wire [2:0] s;\n  output [3:0] q;\n  reg [3:0] q;\n"
            f"  always_comb begin\n{block}  end\nendmodule\n")


def assert_equal_logic(first, second, top, folder):
    """All outputs and registers of two modules have the same values."""
    commands = []
    for name, text, options in ("first", first, "-sv"), ("second", second, ""):
        (folder / f"{name}.v").write_text(text)
        commands += [f"read_verilog {options} {name}.v", f"prep -flatten -top {top}", "memory_map",
                     f"rename {top} {name}", f"design -stash {name}"]
    yosys(folder / "equal.log", *commands, *(f"design -copy-from {name} {name}" for name in ("first", "second")),
          "equiv_make first second both", "hierarchy -top both", "equiv_simple", "equiv_status -assert")


@pytest.mark.parametrize("kind", BLOCKS)
def test_a_block_and_its_assignments_are_equal(kind, tmp_path):
    text = module(BLOCKS[kind])
    plain = plain_verilog(text)
    assert "always" not in plain
    assert_equal_logic(text, plain, "top", tmp_path)


def test_a_wrong_assignment_is_noticed(tmp_path):
    """The comparison can fail."""
    text = module(BLOCKS["parts"])
    with pytest.raises(InputError, match="equal"):
        assert_equal_logic(text, plain_verilog(text).replace("b[1:0]", "b[2:1]"), "top", tmp_path)


@pytest.mark.parametrize("block", ["    q <= a;\n", "    q = a + b;\n", "    q = missing;\n", "    q = 3'h0;\n",
                                   "    while (a) begin\n    end\n", "    if (s[0]) begin\n      q = a;\n"])
def test_a_block_of_another_form_is_refused(block):
    with pytest.raises(RuntimeError, match=r"^Yosys must write combinational blocks in the form that is known"):
        plain_verilog(module(block))


def test_a_wire_is_no_longer_a_register():
    assert re.findall(r"(?m)^  (?:reg|wire) .*q;$", plain_verilog(module(BLOCKS["parts"]))) == ["  wire [3:0] q;"]


def test_the_router_in_verilog_is_that_in_systemverilog(router, tmp_path):
    files = router[1]
    first, second = (files[f"radiosity_router.{kind}"].decode() for kind in ("sv", "v"))
    assert not waiting(first)
    assert not waiting(second)
    assert "always_comb" in first
    assert_equal_logic(first, second, "radiosity_router", tmp_path)
