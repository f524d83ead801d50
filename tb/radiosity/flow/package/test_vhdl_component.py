"""The VHDL component of an exported module has its ports."""

import re

import pytest

from golden.engine.config import PRESETS
from radiosity.flow.package.manifest import manifest
from radiosity.flow.package.vhdl_component import vhdl_component


@pytest.mark.parametrize("top", ["engine", "router"])
def test_ports_are_those_of_the_manifest(top, monkeypatch):
    monkeypatch.setattr("radiosity.flow.package.manifest.unit_latencies", lambda *_: {})
    name = f"radiosity_{top}"
    ports = manifest(top, name, config=PRESETS["tiny"], preset="tiny", text="")["ports"]
    text = vhdl_component(name, "A module", ports)
    found = re.findall(r"(?m)^ +(\w+) : (in|out) (?:std_logic_vector\((\d+) downto 0\)|std_logic)(;?)$", text)
    assert [(one, kind + "put", int(high or 0) + 1) for one, kind, high, _ in found] == [
        (port["name"], port["direction"], port["width"]) for port in ports]
    # A semicolon separates ports: the last one has none.
    assert [end for *_, end in found] == [";"] * (len(ports) - 1) + [""]


def test_a_package_has_the_component_of_the_modules_name():
    text = vhdl_component("radiosity_x", "A module", [{"name": "clk", "direction": "input", "width": 1},
                                                      {"name": "word", "direction": "output", "width": 3}])
    assert text == """\
-- A module: the component of the module radiosity_x, whose Verilog is radiosity_x.v.

library ieee;
use ieee.std_logic_1164.all;

package radiosity_x_component is
    component radiosity_x is
        port (
            clk : in std_logic;
            word : out std_logic_vector(2 downto 0)
        );
    end component;
end package;
"""
