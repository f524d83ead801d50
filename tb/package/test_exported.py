"""Exported Verilog in simulators: hits are those of the golden model."""

import pytest
from amaranth.lib.wiring import In

from golden.config import PRESETS
from hw.lib.black_box import flatten
from hw.lib.inspection import inspect
from hw.package.port_names import port_name
from hw.package.tops import TOPS
from tb.lib.runner import SIMULATORS, simulate
from tb.package.test_core_files import written

CYCLES = 20_000_000


def exported(top, preset, folder):
    """Its Verilog in a module ``top`` whose ports have the names by which benches find them."""
    text = written(folder, "--top", top, "--preset", preset)[f"radiosity_{top}.v"].decode()
    members = inspect(lambda: TOPS[top].make(PRESETS[preset]), lambda one: [
        (path, "input" if member.flow is In else "output", len(value)) for path, member, value in flatten(one)])
    ports = [("clk", "input", 1), ("rst", "input", 1), *members]
    # Benches wait for edges of scalars: one bit has no range.
    declared = ", ".join(f"{direction} {f'[{width - 1}:0] ' * (width > 1)}{path}" for path, direction, width in ports)
    connected = ", ".join(f".{port_name(path)}({path})" for path, *_ in ports)
    return f"{text}\nmodule top({declared});\n  radiosity_{top} core({connected});\nendmodule\n"


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
