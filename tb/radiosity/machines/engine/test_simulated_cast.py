"""The simulated cluster has the cycles of the hardware."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.machines import SceneCasts, errors_of, machine_config, recorded_cycles
from radiosity.machines.engine.cluster_latencies import cluster_timing
from radiosity.machines.engine.section_trace import replay

pytestmark = pytest.mark.usefixtures("interpreted")

CONFIG = machine_config("paper", (), (256, 64))


def errors(rows, config=CONFIG):
    recorded = recorded_cycles()
    return abs(errors_of({row: recorded[row] for row in rows}, config))


def test_cycles_are_those_of_the_hardware():
    assert errors([("tetra", 0.35)]).max() < 0.02


@pytest.mark.nightly
def test_cycles_are_those_of_the_hardware_for_all_cells():
    error = errors(recorded_cycles())
    assert len(error) == 54
    assert error.mean() < 0.02
    assert error.max() < 0.10


@pytest.mark.nightly
@pytest.mark.parametrize(("row", "changes"), [
    (("lobby", 0.0625), {"ctu.run_ahead": 0}), (("tetra", 0.35), {"icu.slots": 16})])
def test_another_rule_has_other_cycles(row, changes):
    assert errors([row], CONFIG.replace(changes))[0] > 0.05


def test_survival_without_the_sweep_has_other_cycles(monkeypatch):
    timing = replace(cluster_timing(CONFIG), sweep=1 << 40)
    monkeypatch.setattr("benchmarks.machines.cluster_timing", lambda config: timing)
    assert errors([("lobby", 0.0625)])[0] > 0.05


@pytest.mark.parametrize("changes", [{}, {"icu.slots": 16, "ctu.run_ahead": 0}])
def test_a_replay_has_the_events_of_the_cast(changes):
    config = machine_config("paper", (), (32, 32)).replace(changes)
    cast = SceneCasts("cornell", config, rays=(32, 32)).cast(0.125)
    times = replay(cast.trace, cluster_timing(config), slots=config.icu.slots, run_ahead=config.ctu.run_ahead)
    assert np.array_equal(times.begins, cast.times.begins)
    assert np.array_equal(times.ends, cast.times.ends)
    assert (times.free, times.cycles) == (cast.times.free, cast.times.cycles)


def test_two_lanes_halve_the_cycles_of_tests_at_most():
    """Cycles of a tile with an odd number of rays are rounded up, and a patch's walk reads each tile once."""
    config = machine_config("paper", (), (64, 16))
    one, two = (SceneCasts("cornell", config, rays=(64, 16)).cast(0.35, lanes=lanes) for lanes in (1, 2))
    assert 1.3 < one.trace.tests.sum() / two.trace.tests.sum() <= 2
    assert 1.2 < one.times.cycles / two.times.cycles < 2
