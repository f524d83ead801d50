"""The netlist of the engine, as it is placed, with LUTs folded into carry cells, casts as golden does."""

import pytest

from golden.engine.config import PRESETS
from golden.engine.jobs.job import plan_job
from hw.engine import Engine
from radiosity.flow.synthesis.flow import synthesise
from tb.radiosity.flow.synthesis.netlist import netlist_library
from tb.system.job_machine import JobMachine
from tb.system.scenes import phase


@pytest.mark.nightly
@pytest.mark.parametrize(("preset", "clusters"), [("tiny", 1), ("board", 1), ("board", 2)])
def test_its_hemisphere_is_goldens(preset, clusters, tmp_path):
    """Of two clusters each casts a half."""
    config = PRESETS[preset].replace({"noc.columns": clusters, "noc.rows": 1})
    # Otherwise folds are not among what casts.
    assert synthesise(Engine(config=config), tmp_path).folded > 0
    library = netlist_library(tmp_path / "area.json", config, tmp_path / "library")
    job = plan_job([phase("cornell", config, cell=0.25, rays=(16, 8), points=(5, 1), clusters=clusters)], config)
    with JobMachine(job, library=library) as machine:
        assert {int(one) for one in machine.right()["cluster"]} >= set(range(clusters))
