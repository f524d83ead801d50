"""Exported Verilog in simulators: hits are those of the golden model."""

import pytest
from amaranth.lib.wiring import In

from golden.engine.config import PRESETS
from hw.lib.black_box import flatten
from hw.lib.inspection import inspect
from radiosity.flow.package.port_names import port_name
from radiosity.flow.package.tops import TOPS
from tb.lib.runner import SIMULATORS, simulate
from tb.radiosity.flow.package.exported_engine import written

CYCLES = 20_000_000


def exported(top, preset, folder, *, driven=None, more=""):
    """Its Verilog in a module ``top`` whose ports have the names by which benches find them.

    ``driven`` has expressions for ports of the core, and ``more`` is what these refer to.
    """
    driven = driven or {}
    text = written(folder, "--top", top, "--preset", preset)[f"radiosity_{top}.v"].decode()
    members = inspect(lambda: TOPS[top].make(PRESETS[preset]), lambda one: [
        (path, "input" if member.flow is In else "output", len(value)) for path, member, value in flatten(one)])
    ports = [("clk", "input", 1), ("rst", "input", 1), *members]
    # Benches wait for edges of scalars: one bit has no range.
    declared = ", ".join(f"{direction} {f'[{width - 1}:0] ' * (width > 1)}{path}" for path, direction, width in ports
                         if path in ("clk", "rst") or path not in driven)
    connected = ", ".join(f".{port_name(path)}({driven.get(path, path)})" for path, *_ in ports)
    return f"{text}\nmodule top({declared});\n{more}  radiosity_{top} core({connected});\nendmodule\n"


@pytest.mark.nightly
@pytest.mark.parametrize("simulator", SIMULATORS)
@pytest.mark.parametrize("preset", PRESETS)
def test_the_intersection_unit(preset, simulator, tmp_path):
    simulate(exported("icu", preset, tmp_path), "tb.icu.test_intersection_unit", ("whole_frusta",), simulator=simulator,
             name=f"exported-icu-{preset}-{simulator}", changes={}, preset=preset, scene="cornell", rays=(32, 8),
             pixels=(24, 18), busy=0, cycles=CYCLES)


@pytest.mark.nightly
@pytest.mark.parametrize("simulator", SIMULATORS)
@pytest.mark.parametrize("preset", ["tiny"])
def test_the_engine(preset, simulator, tmp_path):
    simulate(exported("engine", preset, tmp_path), "tb.system.test_engine_bus", ("whole_job",), simulator=simulator,
             name=f"exported-engine-{preset}-{simulator}", visible=("clk", "rst", "host__*", "axi__*"),
             changes=PRESETS[preset].parameters(), cycles=CYCLES)


@pytest.mark.icarus
@pytest.mark.nightly
@pytest.mark.parametrize("half_period", [3.7, 11.3])
def test_the_engine_between_clocks(half_period, tmp_path):
    """The bench's clock is the buses'; the engine has one that is faster or slower."""
    text = exported("async_engine", "tiny", tmp_path, driven={
        "clk": "engine_clk", "m_axi_aclk": "clk", "m_axi_aresetn": "~rst", "s_axil_aclk": "clk",
        "s_axil_aresetn": "~rst"}, more=f"  reg engine_clk = 0;\n  always #{half_period} engine_clk = ~engine_clk;\n")
    simulate(text, "tb.system.test_engine_bus", ("whole_job",), simulator="icarus",
             name=f"exported-async-engine-{half_period}", visible=("clk", "rst", "host__*", "axi__*"),
             changes=PRESETS["tiny"].parameters(), cycles=CYCLES)
