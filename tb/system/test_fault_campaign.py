"""Faults meet each other in an engine: the job ends with its codes, no entry leaks, and the next job is exact."""

import random

import pytest

from tb.lib.seed import SEED
from tb.system.fault_campaign import FaultCampaign
from tb.system.job_machine import TWO_CLUSTERS

# In a commit the machine of all its tests.
STORE = {"memsys.store_patches": 8, "memsys.store_requests": 4}


@pytest.mark.parametrize(("clusters", "changes", "count"), [
    pytest.param(2, {}, 6, marks=TWO_CLUSTERS),
    *(pytest.param(clusters, STORE, count, marks=pytest.mark.nightly) for clusters, count in (
        (1, 600), (2, 800), (4, 600)))])
def test_faults_upon_faults(clusters, changes, count):
    with FaultCampaign(clusters, **changes) as campaign:
        for number in range(count):
            try:
                campaign.run(random.Random(f"{SEED} {clusters} {number}"))
            except Exception as error:
                error.add_note(f"SEED={SEED}, faults {number}")
                raise
    assert campaign.most_used > 10
    assert campaign.ended >= count // 3
