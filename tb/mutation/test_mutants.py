"""Mutants: the same component, and one that is wrong."""

import shutil

import pytest

from hw.export import verilog_of
from tb.lib.runner import Simulation
from tb.mutation.blocks import BLOCKS, bench_of
from tb.mutation.mutants import make_mutants
from tb.package.test_export import Rom

COUNT = 6
CASE = "tb.package.test_export", ("every_word",)


@pytest.mark.skipif(shutil.which("iverilog") is None, reason="there is no iverilog here")
def test_the_component_and_mutants_of_it():
    mutants = make_mutants(verilog_of(Rom(), "top"), count=COUNT, seed=1)
    assert len(mutants.about) == COUNT
    assert make_mutants(verilog_of(Rom(), "top"), count=COUNT, seed=1) == mutants
    simulation = Simulation(mutants.text, "icarus")
    assert not simulation.run(*CASE, "mutants/rom-0", 1, {})
    failed = [bool(simulation.run(*CASE, f"mutants/rom-{k}", 1, {}, plusargs=(f"+mutant={k}",)))
              for k in range(1, COUNT + 1)]
    assert sum(failed) > COUNT // 2


@pytest.mark.nightly
@pytest.mark.parametrize("block", BLOCKS)
def test_every_block_has_a_bench(block):
    assert "module top(" in bench_of(block).text
