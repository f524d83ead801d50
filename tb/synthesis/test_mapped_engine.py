"""The netlist of the engine casts as golden does."""

import pytest

from hw.engine import Engine
from tb.lib.configurations import config_of
from tb.lib.runner import BUILD, SIMULATORS, simulate
from tb.synthesis.mapped import mapped_text
from tb.system.scenes import frusta, save

# One cluster of the preset `tiny`.
CHANGES = {"noc.columns": 1}


@pytest.mark.nightly
@pytest.mark.parametrize("simulator", SIMULATORS[1:])
def test_the_engine(simulator, tmp_path):
    config = config_of(CHANGES)
    folder = save(frusta("cornell", config, cell=0.25, rays=(16, 8)), BUILD / "vectors" / "engine-mapped")
    simulate(mapped_text(Engine(config=config), tmp_path), "tb.system.test_engine", ("whole_frusta",),
             simulator=simulator, name="engine-mapped", visible=("clk", "rst", "host__*", "axi__*"), changes=CHANGES,
             folder=str(folder), cycles=200_000)
