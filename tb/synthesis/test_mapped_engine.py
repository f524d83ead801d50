"""The netlist of the engine, as it is placed, casts as golden does."""

import pytest

from hw.engine import Engine
from hw.simulator.simulated_machine import SimulatedMachine
from hw.synthesis.flow import synthesise
from tb.lib.configurations import config_of
from tb.synthesis.netlist import netlist_library
from tb.system.scenes import frusta


@pytest.mark.nightly
def test_one_cluster_of_the_preset_tiny(tmp_path):
    config = config_of({"noc.columns": 1})
    synthesise(Engine(config=config), tmp_path)
    library = netlist_library(tmp_path / "area.json", config, tmp_path / "library")
    with SimulatedMachine(config, library=library) as machine:
        for frustum in frusta("cornell", config, cell=0.25, rays=(16, 8)):
            image = machine.cast(frustum.image, total=frustum.total, sums=True).image
            different = image.hits().differences(frustum.hits)
            assert not len(different), f"{len(different)} rays differ, the first is {different[0]}"
            for name in "hits", "sums":
                assert image[name].tobytes() == frustum.written[name].tobytes()
