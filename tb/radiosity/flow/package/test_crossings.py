"""Crossings between the clocks of an exported core: found in its Verilog as in its design, and all constrained."""

import re

import pytest
from amaranth.hdl import Fragment
from amaranth.lib.cdc import AsyncFFSynchronizer, FFSynchronizer
from amaranth.lib.fifo import AsyncFIFO

import hw.async_engine
from golden.engine.config import PRESETS
from hw.async_engine import AsyncEngine
from radiosity.flow.package.constraints import lpf, sdc, xdc
from radiosity.flow.package.crossings import crossings, with_synchronisers
from radiosity.flow.verilog.export import verilog_of
from tb.system.copier import Copier

CLOCKS = "clk", "m_axi_aclk", "s_axil_aclk"
NAME = "radiosity_async_engine"


def inside(fragment, path=()):
    """All components of a design with their paths."""
    for origin in fragment.origins or ():
        yield path, origin
    for part, name, _ in fragment.subfragments:
        yield from inside(part, (*path, name))


@pytest.fixture(scope="module")
def made():
    """The components of an engine between clocks, a small unit in its middle, and its Verilog."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(hw.async_engine, "Engine", Copier)
        engine = AsyncEngine(config=PRESETS["tiny"], black_boxes=True)
        text = verilog_of(engine, NAME)
        components = [*inside(Fragment.get(AsyncEngine(config=PRESETS["tiny"], black_boxes=True), None))]
    return components, text


def test_each_queue_between_clocks_has_both_of_its_counters_bounded(made):
    components, text = made
    queues = [path for path, one in components if isinstance(one, AsyncFIFO)]
    assert len(queues) == 10, "five channels of each bus"
    found = crossings(text, NAME)
    expected = sorted((path, counter, f"{instance}/stage0") for path in queues for counter, instance in (
        ("produce_w_gry", "produce_cdc"), ("consume_r_gry", "consume_cdc")))
    assert [(one.path, one.source, one.sink) for one in found] == expected
    vivado, quartus = (write(CLOCKS, period=7.5, crossings=found) for write in (xdc, sdc))
    assert re.findall(r"set_bus_skew -from \[get_cells {(.*)_reg\[\*\]}\] -to \[get_cells {(.*)_reg\[\*\]}\] 7\.5\n",
                      vivado) == [("/".join((*path, source)), "/".join((*path, sink)))
                                  for path, source, sink in expected]
    assert len(re.findall(r"set_max_skew -from .*produce_w_gry\[\*\]}\] -to .*produce_cdc\|\*stage0\[\*\]}\] 7\.5\n",
                          quartus)) == len(queues)
    assert len(re.findall("set_max_skew -from", quartus)) == len(expected)


def test_paths_between_clocks_are_bounded_in_both_directions():
    text = xdc(CLOCKS, period=8, crossings=[])
    pairs = re.findall(r"set_max_delay -datapath_only -from \[get_clocks (\w+)\] -to \[get_clocks (\w+)\] 8\n", text)
    assert {*pairs} == {(one, other) for one in CLOCKS for other in CLOCKS if one != other}
    # It has precedence over bounds of delays.
    assert "set_clock_groups" not in text
    assert "set_clock_groups" in sdc(CLOCKS, period=8, crossings=[])


def test_a_core_of_one_clock_has_that_clock_alone():
    for text in xdc(("clk",), period=8, crossings=[]), sdc(("clk",), period=8, crossings=[]):
        assert text == "create_clock -name clk -period 8 [get_ports clk]\n"
    assert lpf(("clk",), period=8) == 'FREQUENCY PORT "clk" 125 MHZ;\n'


def test_each_register_of_a_synchroniser_has_its_attribute(made):
    """As many as the synchronisers of the design have stages, and no other register."""
    components, text = made
    stages = sum(one._stages for _, one in components if isinstance(one, (FFSynchronizer, AsyncFFSynchronizer)))
    marked = re.findall(r'  \(\* ASYNC_REG = "TRUE" \*\)\n  reg (?:\[\d+:0\] )?(\S+) = ', with_synchronisers(text))
    assert stages > 60
    assert len(marked) == stages
    assert {name.rstrip("0123456789") for name in marked} == {"stage"}
