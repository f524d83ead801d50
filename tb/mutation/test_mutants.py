"""Mutants: the same component, and one that is wrong."""

from unittest import mock

import cocotb
import pytest

from hw.export import verilog_of
from tb.lib.clocking import start
from tb.lib.runner import Run, Simulation
from tb.mutation import score
from tb.mutation.blocks import BLOCKS, run_of
from tb.mutation.mutants import make_mutants
from tb.package.test_export import Rom

COUNT = 6
CASE = "tb.package.test_export", ("every_word",)


@pytest.mark.icarus
@pytest.mark.nightly
def test_the_component_and_mutants_of_it():
    mutants = make_mutants(verilog_of(Rom(), "top"), count=COUNT, seed=1)
    assert len(mutants.about) == COUNT
    assert make_mutants(verilog_of(Rom(), "top"), count=COUNT, seed=1) == mutants
    simulation = Simulation(mutants.text, "icarus")
    assert not simulation.run(*CASE, "mutants/rom-0", 1, {})
    failed = [bool(simulation.run(*CASE, f"mutants/rom-{k}", 1, {}, plusargs=(f"+mutant={k}",)))
              for k in range(1, COUNT + 1)]
    assert sum(failed) > COUNT // 2


@cocotb.test()
async def looks_at_nothing(dut):
    await start(dut, cycles=100)


@pytest.mark.sim
def test_mutants_survive_without_checks():
    text = verilog_of(Rom(), "top")
    nothing = Run(text, "tb.mutation.test_mutants", ("looks_at_nothing",), {})
    with mock.patch.object(score, "run_of", return_value=nothing):
        found = score.score("rom", "rom", count=COUNT, seed=1, processes=2)
    left = [*found["survivors"], *map(str, found["equivalent"])]
    assert sorted(left) == [str(number) for number in range(1, COUNT + 1)]
    # Were all of them the same as the component, there would be nothing to compare.
    assert found["survivors"]


@pytest.mark.nightly
@pytest.mark.parametrize(("block", "part"), [(block, part) for block, parts in BLOCKS.items() for part in parts])
def test_every_part_has_a_testbench(block, part):
    assert "module top(" in run_of(block, part).text
