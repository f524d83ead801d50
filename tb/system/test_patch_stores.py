"""Jobs of scenes that no cluster holds: patch stores serve what others hold, and hits and sums are golden's."""

import numpy as np
import pytest

from golden.engine.jobs.job import plan_job
from hw.registers.error_code import ErrorCode
from radiosity.flow.simulator.simulated_port import complete
from tb.system.job_machine import BASE, CONFIGS, JobMachine
from tb.system.job_memory import JobMemory
from tb.system.scenes import phase

# Each cluster holds 16 patches, and 8 of others: a part of the scene stays in main memory.
CONFIG = CONFIGS[2]
# Until the stop, during the first phase.
CYCLES = 9000
SOURCES = ("own", "remote", "hits", "misses")


@pytest.mark.nightly
def test_hits_and_sums_are_golden_after_loads_and_a_stop():
    """Frusta that find what others have left; after another scene's load, and after a reset, nothing of before it."""
    phases = [phase(scene, CONFIG, cell=0.25, rays=(32, 16), points=(5, 1, 2, 0, 3, 5))
              for scene in ("cornell", "lobby", "cornell")]
    expected = JobMemory(plan_job(phases, CONFIG, base=BASE))
    for memory in {"latency": 10}, {"latency": 5, "spread": 60, "shuffles": True, "seed": 3}:
        with JobMachine(expected.job, expected=expected, **memory) as machine:
            records = machine.right()
            served = sum(records[name].astype(int) for name in SOURCES)
            # The rest of the patches found are from the stores.
            assert (served <= records["found"]).all()
            assert records["found"].sum() - served.sum() > 30
            assert all(records[name].sum() > 0 for name in ("own", "remote", "misses"))
            machine.begin()
            machine.submit()
            complete(machine.port.wait(CYCLES))
            machine(machine.host.command("stop"))
            records = machine.ended()
            aborted = {int(record["tag"]): ErrorCode(int(record["error"])) for record in records if record["error"]}
            assert {*aborted.values()} == {ErrorCode.ABORTED}
            records += machine.resumed()
            machine.check(np.array(records), aborted)
