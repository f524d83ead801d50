"""Clusters that cast together take what each takes alone, and what patches of other clusters take."""

import re
from dataclasses import asdict, replace

import numpy as np
import pytest

from benchmarks.machine_cuts import cut_config, recorded_cuts, simulated_cuts
from benchmarks.machine_memory import recorded_memory, simulated_memory
from golden.base.errors import InputError
from golden.engine.config import PRESETS
from golden.engine.noc.routing import route
from golden.engine.noc.topology import Topology
from radiosity.machines.engine.cluster_latencies import cluster_timing
from radiosity.machines.engine.job_latencies import joint_timing
from radiosity.machines.engine.joint_cast import JointTiming, joint_cast
from tb.radiosity.machines.engine.scenarios import joint_casts, joint_runs, joint_traces
from tb.radiosity.machines.engine.simpy_joint import simpy_joint
from tb.radiosity.machines.engine.trace_source import replay

CONFIG = cut_config(4)
pytestmark = pytest.mark.usefixtures("interpreted")


def alone(clusters):
    return [replay(trace, cluster_timing(PRESETS["paper"]), slots=8, run_ahead=1)
            for trace in joint_traces(clusters)[0]]


def test_clusters_with_all_patches_are_independent():
    for number, expected in enumerate(alone(2)):
        found = joint_casts(joint_cast, columns=2, rows=1, holder=number).times[number]
        assert np.array_equal(found.begins, expected.begins)
        assert np.array_equal(found.ends, expected.ends)
        assert (found.free, found.cycles) == (expected.free, expected.cycles)


def test_patches_of_other_clusters_come_later():
    found, expected = joint_casts(joint_cast, columns=2, rows=2).times, alone(4)
    assert sum(one.cycles for one in found) > sum(one.cycles for one in expected)
    assert [len(one.ends) for one in found] == [len(one.ends) for one in expected]
    assert all((one.ends > 0).all() for one in found)


def test_one_owner_of_all_patches_is_a_bottleneck():
    spread, single = (
        sum(int(one.ends.sum()) for one in joint_casts(joint_cast, columns=2, rows=2, holder=holder).times[1:])
        for holder in (None, 0))
    assert single > spread


@pytest.mark.nightly
def test_cycles_of_all_cuts_are_those_of_the_hardware():
    error = [abs(simulated / row.cycles - 1) for row, simulated in simulated_cuts(recorded_cuts())]
    assert len(error) == 26
    assert np.mean(error) < 0.05
    assert max(error) < 0.10


@pytest.mark.nightly
def test_patches_of_main_memory_take_the_cycles_of_the_hardware():
    rows = [row for row in recorded_memory() if row.scene == "tetra"]
    (row, cycles), = simulated_memory(rows)
    assert abs(cycles / row.cycles - 1) < 0.03
    (_, near), = simulated_memory([replace(row, latency=10)])
    assert near < 0.9 * row.cycles


@pytest.mark.nightly
def test_the_thesis_machine_takes_the_cycles_of_the_hardware(monkeypatch):
    """Subshell lists with a barrier after each subshell, without which a cast has too few cycles."""
    rows = [row for row in recorded_memory() if row.preset == "thesis"]
    (row, cycles), = simulated_memory(rows)
    assert abs(cycles / row.cycles - 1) < 0.01

    def without_barriers(traces, *others, **options):
        assert any(trace.is_barrier.any() for trace in traces)
        return joint_cast([replace(trace, is_barrier=np.zeros_like(trace.is_barrier)) for trace in traces], *others,
                          **options)

    monkeypatch.setattr("benchmarks.machine_memory.joint_cast", without_barriers)
    (_, cycles), = simulated_memory(rows)
    assert cycles < 0.9 * row.cycles


@pytest.mark.nightly
def test_all_frusta_with_main_memory_take_the_cycles_of_the_hardware():
    error = [abs(cycles / row.cycles - 1) for row, cycles in simulated_memory(recorded_memory())]
    assert len(error) == 12
    assert np.mean(error) < 0.01
    assert max(error) < 0.015


@pytest.mark.nightly
def test_replies_share_the_port_and_the_link_of_their_owner(monkeypatch):
    """One cluster serves all others; replies that do not wait for each other take too few cycles."""
    rows = [row for row in recorded_cuts() if (row.topology, row.sets, row.cell) == ("ring", "first", 0.5)]
    (row, cycles), = simulated_cuts(rows)
    assert abs(cycles / row.cycles - 1) < 0.06
    timing = replace(joint_timing(CONFIG), port=1, reply_flits=1)
    monkeypatch.setattr("benchmarks.machine_cuts.joint_timing", lambda config: timing)
    (_, cycles), = simulated_cuts(rows)
    assert cycles < 0.75 * row.cycles


@pytest.mark.parametrize("bits", [16, 72, 256])
def test_the_link_of_an_owner_hides_its_port(bits):
    """However wide flits are: a reply has one for its header and one for each vertex."""
    timing = joint_timing(CONFIG.replace({"noc.flit_bits": bits}))
    assert timing.reply_flits > timing.port


def test_requests_share_the_port_of_their_owner():
    """Replies of five flits occupy the owner's link longer than its port; only shorter ones wait for the port."""
    for flits, waits in ((1, True), (5, False)):
        shared, single = (joint_runs(joint_cast, columns=2, rows=2, reply_flits=flits, port=port) for port in (4, 1))
        assert np.array_equal(shared, single) != waits


# Replies that are shorter than a patch takes its cluster wait there, others in the network.
@pytest.mark.parametrize("options", [
    {"columns": 2, "rows": 1, "run_ahead": 0, "request": 3, "serve": 2, "reply": 6},
    {"columns": 2, "rows": 2, "reply_flits": 1},
    {"columns": 2, "rows": 2, "run_ahead": 6, "barrier": 2},
    {"columns": 2, "rows": 1, "frames": 16, "cached": "lru", "run_ahead": 6},
    {"columns": 2, "rows": 2, "frames": 8, "cached": "direct"},
    {"columns": 2, "rows": 1, "frames": 8, "cached": "lru", "in_order": True, "run_ahead": 6},
    *(pytest.param({"columns": 4, "rows": 4, **more}, marks=pytest.mark.nightly)
      for more in ({"run_ahead": 6}, {"cached": "lfu"}, {"frames": 8, "run_ahead": 6}))])
def test_events_are_those_of_processes_in_simpy(options):
    found, expected = (joint_runs(run, **options) for run in (joint_cast, simpy_joint))
    assert np.array_equal(found, expected)


def test_clusters_may_know_other_owners():
    """Each holds all patches that it needs, as it knows: the network carries nothing."""
    (traces, _), config = joint_traces(2), CONFIG
    home = np.tile(np.arange(2)[:, None], 50)
    found = joint_cast(traces, home, cluster_timing(config), joint_timing(config), routing=route(
        Topology("mesh", 2, 1), config.noc.virtual_channels), buffer_flits=config.noc.buffer_flits,
        arbitration=config.noc.arbitration, router_cycles=config.noc.router_cycles, slots=8, run_ahead=1)
    assert [one.cycles for one in found.times] == [one.cycles for one in alone(2)]


def test_patches_that_no_cluster_holds_are_refused():
    with pytest.raises(InputError, match=re.escape("Patches of a joint cast without a bus must be held by clusters")):
        joint_casts(joint_cast, columns=2, rows=1, holder=-1)


@pytest.mark.parametrize(("wrong", "error", "message"), [
    ({"reply_flits": 0}, ValueError, "Reply-flits must be at least 1, not 0"),
    ({"serve": 1.5}, TypeError, "Serve must be an int, not 1.5")])
def test_numbers_out_of_range_are_refused(wrong, error, message):
    with pytest.raises(error, match=message):
        JointTiming(**asdict(joint_timing(CONFIG)) | wrong)
