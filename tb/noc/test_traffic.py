"""Traffic is what its pattern says, and measurements are those of the definitions."""

import numpy as np
import pytest

from benchmarks.traffic import PATTERNS, Window, bernoulli, bound, hot_node, measure, observed, pattern
from golden.base.errors import InputError
from golden.engine.noc.delay import zero_load_latency
from golden.engine.noc.network import NEVER, Arrivals, Packets
from golden.engine.noc.routing import route
from golden.engine.noc.topology import Topology

SHAPES = [("mesh", 4, 4), ("mesh", 8, 8), ("torus", 5, 3), ("hypercube", 8, 4), ("ring", 7, 1)]


@pytest.mark.parametrize("shape", SHAPES, ids=str)
def test_nodes_send_all_that_they_make(shape):
    topology = Topology(*shape)
    for name in PATTERNS:
        assert np.allclose(pattern(name, topology).sum(axis=1), 1)
    for name in "transpose", "neighbour":
        assert np.array_equal(pattern(name, topology).sum(axis=0), np.ones(topology.nodes))


def test_patterns_of_a_square_are_those_of_the_literature():
    topology = Topology("mesh", 4, 4)
    assert pattern("transpose", topology)[1].argmax() == 4
    assert pattern("transpose", topology)[7].argmax() == 13
    assert pattern("neighbour", topology)[7].argmax() == 8
    assert [hot_node(Topology("mesh", side, side)) for side in (4, 8)] == [10, 36]
    assert np.allclose(pattern("hotspot", topology)[3, 9:12], [0.9 / 16, 0.9 / 16 + 0.1, 0.9 / 16])
    with pytest.raises(InputError, match="Pattern must be one of uniform, transpose, hotspot, neighbour, not 'storm'"):
        pattern("storm", topology)


@pytest.mark.parametrize(("side", "name", "expected"), [
    (4, "uniform", 1), (8, "uniform", 0.5), (4, "transpose", 1 / 3), (8, "transpose", 1 / 7), (4, "hotspot", 0.4),
    (8, "hotspot", 1 / 7.3), (4, "neighbour", 1)])
def test_bounds_are_the_closed_forms(side, name, expected):
    topology = Topology("mesh", side, side)
    assert bound(route(topology, 1), pattern(name, topology)) == pytest.approx(expected)


def test_a_torus_bears_twice_what_a_mesh_does():
    topology = Topology("torus", 8, 8)
    assert bound(route(topology, 2), pattern("uniform", topology)) == pytest.approx(1)


def test_packets_follow_the_offered_load_and_the_pattern():
    topology = Topology("mesh", 4, 4)
    packets = bernoulli(pattern("hotspot", topology), load=0.6, length=5, cycles=20_000, seed=3)
    assert packets.length.sum() / 20_000 / 16 == pytest.approx(0.6, rel=0.02)
    share = np.bincount(packets.destination, minlength=16) / len(packets)
    assert share == pytest.approx(pattern("hotspot", topology)[0], abs=0.005)
    assert (np.diff(packets.made) >= 0).all()
    turned = bernoulli(pattern("transpose", topology), load=0.5, length=1, cycles=100, seed=3)
    assert np.array_equal(turned.destination, turned.source % 4 * 4 + turned.source // 4)


def test_what_is_measured_is_the_window():
    # Two flits each; made before, within, within, after. The second one's last flit comes behind the window.
    packets = Packets(source=np.array([0, 0, 1, 1]), destination=np.array([1, 1, 0, 0]), length=np.full(4, 2),
                      made=np.array([9, 10, 15, 20]), message=np.zeros(4, dtype=int))
    taken = np.array([11, 12, 19, 20, 18, 19, 30, NEVER])
    arrivals = Arrivals(packet=np.repeat(np.arange(4), 2), entered=taken, entry=taken, left=taken, channel=taken,
                        taken=taken, credits=np.empty((0, 3), dtype=int))
    window = Window(warm_up=10, measured=10, drain=10)
    seen = observed(packets, arrivals, window, np.arange(2))
    assert (seen.accepted, seen.latency) == (5 / 20, (10 + 4) / 2)
    assert observed(packets, arrivals, Window(warm_up=10, measured=11, drain=9), np.arange(2)).latency == np.inf


def test_loads_run_side_by_side_without_meeting():
    topology, window = Topology("mesh", 4, 4), Window(warm_up=200, measured=500, drain=200)
    routing, probabilities = route(topology, 1), pattern("uniform", topology)
    low, _ = measure(routing, probabilities, loads=(0.02, 1), length=1, buffer_flits=8, window=window, seed=1)
    alone, = measure(routing, probabilities, loads=(0.02,), length=1, buffer_flits=8, window=window, seed=1)
    assert low == alone
    assert low.latency == pytest.approx(zero_load_latency(topology.hops.mean()), rel=0.1)


@pytest.mark.parametrize(("channels", "side", "load", "latency"), [
    (1, 4, 0.6, 20), (2, 4, 0.75, 20), (4, 4, 0.77, 20), (1, 8, 0.33, 30), (4, 8, 0.42, 30)])
def test_networks_bear_what_those_of_the_literature_do(channels, side, load, latency):
    topology, window = Topology("mesh", side, side), Window(warm_up=500, measured=500, drain=200)
    seen, = measure(route(topology, channels), pattern("uniform", topology), loads=(load,), length=1, buffer_flits=8,
                    window=window, seed=7)
    assert seen.latency < latency
    assert seen.accepted == pytest.approx(load, abs=0.02)
