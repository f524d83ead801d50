"""Jobs on machines with beats of 256 and 512 bits: each byte of main memory is golden's."""

import pytest

from golden.engine.jobs.job import plan_job
from golden.engine.jobs.result_formats import HitFormat
from tb.lib.configurations import config_of
from tb.system.job_machine import BASE, SMALL, JobMachine
from tb.system.scenes import phase

FORMATS = HitFormat.FULL, HitFormat.COMPACT, HitFormat.IDS, HitFormat.NONE


@pytest.mark.nightly
@pytest.mark.parametrize("data_bits", [512, 256])
def test_hits_and_sums_are_golden(data_bits):
    """All formats, and frusta whose rows begin anywhere in a beat."""
    config = config_of(SMALL | {"noc.columns": 2, "memory.data_bits": data_bits})
    phases = [phase("cornell", config, cell=0.25, rays=rays, points=(5, 1, 6), sets="scheduled", hit_format=hit_format)
              for hit_format, rays in zip(FORMATS, ((32, 16), (16, 8), (8, 16), (32, 8)), strict=True)]
    phases.append(phase("cornell", config, cell=0.25, pixels=(29, 21)))
    job = plan_job(phases, config, base=BASE)
    for memory in {"latency": 10}, {"latency": 5, "spread": 60, "shuffles": True, "seed": 3}:
        with JobMachine(job, **memory) as machine:
            machine.right()
