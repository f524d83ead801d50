"""The simulated cluster has the cycles of the hardware."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.engine import machine_config
from benchmarks.machines import SceneCasts, errors_of, recorded_cycles
from golden.engine.cast.shelling import Shelling
from golden.engine.ctu.sector import Sector
from golden.scene.builtin import builtin_scene
from radiosity.machines.engine.cluster_latencies import cluster_timing
from radiosity.machines.engine.simulated_cast import cast_section
from tb.golden.engine.cast.drawn_shadows import drawn_frustum
from tb.radiosity.machines.engine.trace_source import replay

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


def shadow_cast(ends=lambda record: record.end, **section):
    """The cast of a shadow frustum in a room, of which a twentieth of the positions have rays; and the frustum."""
    config = CONFIG.replace({"icu.shadow_bits": 10})
    geometry, record, _ = drawn_frustum(0, builtin_scene("cornell"), share=0.05)
    record = replace(record, end=ends(record))
    return record, cast_section(Shelling(geometry, config, cell=0.25, by_code=True), record, config,
                                cluster_timing(config), section=replace(Sector.whole(record), **section))


def test_a_shadow_frustum_begins_a_cycle_later_for_each_ray_of_its_list():
    """More rays that nothing blocks, since they end nearly at once, change nothing else."""
    def more(record):
        end, high = record.end.copy(), record.numbers.inverse.high
        end[np.flatnonzero(end == high)[:25]] = high - 1
        return end

    (record, one), (longer, other) = shadow_cast(), shadow_cast(more)
    assert len(longer.listed) - len(record.listed) == 25
    assert 0 < one.tests == other.tests
    assert (other.times.begins - one.times.begins == 25).all()
    assert (other.times.ends - one.times.ends == 25).all()
    assert (other.times.free - one.times.free, other.times.cycles - one.times.cycles) == (25, 25)


def test_rays_of_a_shadow_frustum_that_are_not_listed_are_not_tested():
    """Without a ray near cells are opened, and those of shell 2 before the first sweep."""
    record, one = shadow_cast()
    _, none = shadow_cast(lambda record: np.full(len(record), record.numbers.inverse.high))
    assert (none.tests, none.trace.listing) == (0, one.trace.listing - len(record.listed) + 1)
    assert 0 < none.cells < one.cells
    # A test at least of each ray that is blocked, at most one of each ray and patch of the room.
    assert 0 < one.tests < len(builtin_scene("cornell")) * len(record.listed)


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
