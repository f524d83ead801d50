"""A fixed set of jobs takes the cycles that it took: neither more nor fewer."""

import json
from pathlib import Path

import pytest

from tb.system.cycles import BASELINE, JOBS, cycles_of
from tb.system.job_machine import CLUSTERS

README = Path(__file__).parents[2] / "README.md"
# The job and the clusters of the README's number.
QUOTED = "many rays", 2

# What a job may take more or less; where that is meant, `python -m tb.system.cycles` writes the baseline anew.
SHARE = 0.02


@pytest.mark.parametrize("clusters", CLUSTERS)
@pytest.mark.parametrize("name", JOBS)
def test_cycles_stay(name, clusters):
    expected = json.loads(BASELINE.read_text())[str(clusters)][name]
    found = cycles_of(name, clusters)
    for now, before in zip([found["job"], *found["casts"]], [expected["job"], *expected["casts"]], strict=True):
        assert abs(now - before) <= SHARE * before, (
            f"{name}: {found} cycles instead of {expected}; if that is meant: python -m tb.system.cycles")
    if (name, clusters) == QUOTED:
        cycles, = found["casts"]
        assert f"| **{cycles:,}** | cycles" in README.read_text()
