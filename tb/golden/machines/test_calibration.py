"""Simulated frusta with a changed rule miss the hardware's cycles by more than the calibration allows."""

from dataclasses import replace

import pytest

import radiosity.benchmarks.machine_cuts
import radiosity.benchmarks.machine_memory
from radiosity.benchmarks.machine_cuts import recorded_cuts, simulated_cuts
from radiosity.benchmarks.machine_memory import recorded_memory, simulated_memory

# Of the worst row.
WORST = 0.10


def cut_error():
    """The error of a frustum of lobby that four clusters share."""
    rows = [row for row in recorded_cuts() if (row.scene, row.topology, row.clusters) == ("lobby", "mesh", 4)]
    (row, cycles), = simulated_cuts(rows)
    return abs(cycles / row.cycles - 1)


def memory_error():
    """The error of tetra with main memory 50 cycles away."""
    rows = tuple(row for row in recorded_memory() if row.scene == "tetra")
    (row, cycles), = simulated_memory(rows)
    return abs(cycles / row.cycles - 1)


@pytest.mark.nightly
def test_clusters_that_share_a_frustum_have_the_rules_of_one(monkeypatch):
    """Stages that do not overlap, and survival that never sees a settled tile."""
    config, timing = (getattr(radiosity.benchmarks.machine_cuts, name) for name in ("cut_config", "cluster_timing"))
    assert cut_error() < WORST
    with monkeypatch.context() as patch:
        patch.setattr(radiosity.benchmarks.machine_cuts, "cut_config",
                      lambda *given: config(*given).replace({"ctu.run_ahead": 0}))
        assert cut_error() > WORST
    monkeypatch.setattr(radiosity.benchmarks.machine_cuts, "cluster_timing",
                        lambda given: replace(timing(given), sweep=1 << 40))
    assert cut_error() > WORST


@pytest.mark.nightly
@pytest.mark.parametrize("changes", [{"words": 1, "beats": 1, "next_fetch": 1}, {"fetches": 1}])
def test_fetches_share_the_bus_and_main_memory(monkeypatch, changes):
    """Fetches that do not wait for each other, and fetches one after the other."""
    timing = radiosity.benchmarks.machine_memory.bus_timing
    assert memory_error() < WORST
    monkeypatch.setattr(radiosity.benchmarks.machine_memory, "bus_timing",
                        lambda config, latency: replace(timing(config, latency=latency), **changes))
    assert memory_error() > WORST
