"""Names of an exported core's modules and ports: a VHDL design instantiates it."""

import re

import pytest

from golden.engine.config import PRESETS
from hw.lib.black_box import flatten
from hw.lib.inspection import inspect
from hw.lib.skid_buffer import SkidBuffer
from radiosity.flow.package.port_names import port_name
from radiosity.flow.package.tops import TOPS
from radiosity.flow.verilog.export import verilog_of
from tb.radiosity.flow.package.exported_engine import MANIFESTS

pytestmark = MANIFESTS

# IEEE 1076-2019, 15.10.
RESERVED = {
    "abs", "access", "after", "alias", "all", "and", "architecture", "array", "assert", "assume", "attribute",
    "begin", "block", "body", "buffer", "bus", "case", "component", "configuration", "constant", "context", "cover",
    "default", "disconnect", "downto", "else", "elsif", "end", "entity", "exit", "fairness", "file", "for", "force",
    "function", "generate", "generic", "group", "guarded", "if", "impure", "in", "inertial", "inout", "is", "label",
    "library", "linkage", "literal", "loop", "map", "mod", "nand", "new", "next", "nor", "not", "null", "of", "on",
    "open", "or", "others", "out", "package", "parameter", "port", "postponed", "procedure", "process", "property",
    "protected", "private", "pure", "range", "record", "register", "reject", "release", "rem", "report", "restrict",
    "return", "rol", "ror", "select", "sequence", "severity", "signal", "shared", "sla", "sll", "sra", "srl",
    "strong", "subtype", "then", "to", "transport", "type", "unaffected", "units", "until", "use", "variable",
    "view", "vpkg", "vmode", "vprop", "vunit", "wait", "when", "while", "with", "xnor", "xor"}


def is_legal(name):
    """A basic identifier of VHDL (15.4.2): letters, digits, single underscores between them, no reserved word."""
    return bool(re.fullmatch(r"[A-Za-z](_?[A-Za-z0-9])*", name)) and name.lower() not in RESERVED


def check_names(top, names):
    assert not [name for name in names if not is_legal(name)]
    assert len({name.lower() for name in names}) == len(names), "VHDL does not distinguish upper from lower case"


@pytest.mark.parametrize("top", TOPS)
def test_every_name_is_legal_in_vhdl(top, facts_of):
    check_names(top, [f"radiosity_{top}", *(port["name"] for port in facts_of(top)["ports"])])


@pytest.mark.nightly
@pytest.mark.parametrize("top", TOPS)
def test_so_are_those_of_the_thesis_machine(top):
    paths = inspect(lambda: TOPS[top].make(PRESETS["thesis"]), lambda one: [path for path, *_ in flatten(one)])
    check_names(top, [f"radiosity_{top}", "clk", "rst", *map(port_name, paths)])


@pytest.mark.parametrize("name", ["axi__awaddr", "_valid", "valid_", "0_valid", "out", "Signal", "a-b"])
def test_the_rule_refuses_what_vhdl_refuses(name):
    assert not is_legal(name)


def test_buses_have_the_prefixes_that_tools_know(facts_of):
    names = {port["name"] for port in facts_of("engine")["ports"]} - {"clk", "rst"}
    assert {"s_axil_awaddr", "s_axil_rresp", "m_axi_arlen", "m_axi_wstrb", "irq"} <= names
    assert {name.rpartition("_")[0] for name in names} == {"s_axil", "m_axi", ""}


def test_two_ports_of_a_name_are_refused():
    with pytest.raises(ValueError, match=r"^Names of ports must differ, not be same twice$"):
        verilog_of(SkidBuffer(8), "top", port_name=lambda path: "same")
