"""The netlist of the engine, as it is placed, with LUTs folded into carry cells, casts as golden does."""

import json
import random

import pytest

from golden.engine.config import PRESETS
from golden.engine.jobs.job import plan_job
from hw.engine import Engine
from radiosity.flow.board.soc import SOC
from tb.lib.seed import NIGHTS, SEED
from tb.radiosity.flow.synthesis.mapped import compiled_library, mapped_text
from tb.system.job_machine import JobMachine
from tb.system.scenes import phase

# Those that are placed and routed. A night has one of them: it takes a quarter of an hour.
CONFIGS = {"board": PRESETS["board"], "two clusters": PRESETS["board"].replace({"noc.patch_nodes": 0}), "SoC": SOC}


@pytest.mark.nightly
@pytest.mark.parametrize("name", random.Random(SEED).sample([*CONFIGS], min(NIGHTS, len(CONFIGS))))
def test_its_hemisphere_is_goldens(name, tmp_path):
    """In Verilator, by the cells' simulation models. Each cluster casts a part; where there is a network it carries
    patches.
    """
    config = CONFIGS[name]
    clusters = config.noc.clusters
    text = mapped_text(Engine(config=config), tmp_path)
    # Otherwise folds are not among what casts.
    netlist = json.loads((tmp_path / "area.json").read_text())
    assert int(netlist["modules"]["top"]["attributes"]["folded_luts"], 2) > 0
    library = compiled_library(text, config, tmp_path)
    job = plan_job([phase("cornell", config, cell=0.25, rays=(16, 8), points=(5, 1), clusters=clusters)], config)
    with JobMachine(job, library=library) as machine:
        records = machine.right()
        assert {int(one) for one in records["cluster"]} >= set(range(clusters))
        assert (records["remote"].sum() > 0) == (config.noc.nodes > 1)
