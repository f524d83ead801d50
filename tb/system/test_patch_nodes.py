"""Jobs of machines with patch nodes: clusters request what those hold through the network, and hits are golden's."""

import pytest

from golden.engine.config import PRESETS
from golden.engine.jobs.completion import patch_sources
from golden.engine.jobs.job import plan_job
from tb.lib.configurations import config_of
from tb.system.job_machine import BASE, SMALL, JobMachine
from tb.system.scenes import phase


@pytest.mark.parametrize(("clusters", "columns", "rows"), [
    pytest.param(1, 2, 1, marks=pytest.mark.sim, id="a cluster and a patch node"),
    pytest.param(2, 2, 2, marks=pytest.mark.nightly, id="two clusters and two patch nodes")])
def test_hits_and_sums_are_golden_and_patches_come_from_all_nodes(clusters, columns, rows):
    """After another scene's load too. The nodes hold the smaller scene between them, and of the other what fits."""
    config = config_of(SMALL | {"noc.columns": columns, "noc.rows": rows,
                                "noc.patch_nodes": columns * rows - clusters})
    # Of one hemisphere more than clusters some cluster casts two, and finds patches of the first one kept.
    points = (5, 1, 3)[:clusters + 1]
    job = plan_job([phase(scene, config, cell=0.25, rays=(32, 16), points=points) for scene in ("cornell", "lobby")],
                   config, base=BASE)
    for planned in job.phases:
        share = len(planned.image["patches"]) // config.noc.nodes
        assert (planned.image["clusters"]["residents"] == min(share, config.memsys.own_patches)).all()
    with JobMachine(job, latency=10) as machine:
        records = machine.right()
        sections = records[records["found"] > 0]
        assert {*sections["cluster"].tolist()} == set(range(clusters))
        sources = patch_sources(sections)
        assert all(sources[name].all() for name in ("own", "remote"))
        assert sources["kept"].sum() > 0
        assert sources["misses"].sum() > 0


@pytest.mark.nightly
def test_the_board_casts_what_golden_casts():
    """Patches that follow each other take all of its few slots, of hemispheres and of a screen."""
    config = PRESETS["board"]
    job = plan_job([phase("cornell", config, cell=0.25, rays=(64, 16), points=(5, 1)),
                    phase("cornell", config, cell=0.25, pixels=(32, 32))], config)
    with JobMachine(job, latency=2) as machine:
        machine.right()
