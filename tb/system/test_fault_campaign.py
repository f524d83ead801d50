"""Faults meet each other in an engine: the job ends with its codes, no entry leaks, and the next job is exact."""

import random

import pytest

from tb.lib.seed import NIGHTS, SEED
from tb.system.fault_campaign import FaultCampaign
from tb.system.job_machine import TWO_CLUSTERS

# The machine of a commit's tests has a patch store.
NO_STORE = {"memsys.store_patches": 0}


@pytest.mark.parametrize(("clusters", "changes", "count"), [
    pytest.param(2, {}, 6, marks=TWO_CLUSTERS),
    *(pytest.param(clusters, changes, count, marks=pytest.mark.nightly) for clusters, changes, count in (
        (1, {}, 60 * NIGHTS), (2, {}, 80 * NIGHTS), (4, {}, 60 * NIGHTS), (2, NO_STORE, 30 * NIGHTS)))])
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
