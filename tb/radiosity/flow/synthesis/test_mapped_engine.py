"""The netlist of the engine, as it is placed, with LUTs folded into carry cells, casts as golden does."""

import pytest

from golden.engine.jobs.job import plan_job
from hw.engine import Engine
from radiosity.flow.synthesis.flow import synthesise
from tb.lib.configurations import config_of
from tb.radiosity.flow.synthesis.netlist import netlist_library
from tb.system.job_machine import JobMachine
from tb.system.scenes import phase


@pytest.mark.nightly
def test_one_cluster_of_the_preset_tiny(tmp_path):
    config = config_of({"noc.columns": 1})
    # Otherwise folds are not among what casts.
    assert synthesise(Engine(config=config), tmp_path).folded > 0
    library = netlist_library(tmp_path / "area.json", config, tmp_path / "library")
    job = plan_job([phase("cornell", config, cell=0.25, rays=(16, 8), points=(5, 1))], config)
    with JobMachine(job, library=library) as machine:
        machine.right()
