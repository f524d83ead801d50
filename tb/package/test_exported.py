"""Exported Verilog in simulators: hits are those of the golden model."""

import pytest

from golden.config import PRESETS
from tb.lib.runner import SIMULATORS, simulate
from tb.package.test_core_files import written

CYCLES = 20_000_000


def exported(top, preset, folder):
    """Its Verilog; benches find their component by the name ``top``."""
    module = f"module radiosity_{top}("
    text = written(folder, "--top", top, "--preset", preset)[f"radiosity_{top}.v"].decode()
    assert text.count(module) == 1
    return text.replace(module, "module top(")


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
