"""What the network's benchmarks make of their measurements."""

import numpy as np

from benchmarks.ceiling import Ceiling
from benchmarks.network import distances, links, mean, measure
from benchmarks.network_load import Case, Curve, saturations
from benchmarks.thesis_memory import requests_by_memory
from benchmarks.traffic import Measurement
from golden.cast.hemisphere import Hemisphere
from golden.engine.config import PRESETS
from golden.engine.noc.topology import Topology


def test_links_are_counted_for_requests_to_others():
    between = np.zeros((4, 4), dtype=int)
    between[0] = 100, 3, 0, 5
    counts = distances(between, Topology("ring", 4, 1), np.arange(4))
    assert counts[:3].tolist() == [0, 8, 0]
    assert distances(between, Topology("mesh", 4, 1), np.arange(4))[:4].tolist() == [0, 3, 0, 5]
    assert mean(distances(between, Topology("mesh", 4, 1), np.arange(4))) == 18 / 8


def test_all_patches_that_clusters_find_are_requested():
    """Of a cluster that holds them, on the diagonal, or of others; some are in main memory alone."""
    ceiling = Ceiling("lobby", PRESETS["thesis"], cell=0.25, hemisphere=Hemisphere(32, 16))
    plan, between = ceiling.plan(2), measure(ceiling, 2, range(2))
    found = sum(counts.patches for point in range(2) for counts in ceiling.shelling.cast(
        ceiling.record(point), plan.partition.sections, plan.subshells)[1])
    own, others, *memory = np.sum(requests_by_memory(ceiling, 2, 64), axis=0)
    assert found == own + others + sum(memory)
    assert min(own, others, *memory) > 0
    assert between.sum() == own + others
    assert np.trace(between) == own


def curve(*latencies):
    found = [Measurement(accepted=0, latency=latency) for latency in latencies]
    return Curve(loads=np.array([0.01, 0.01, 0.2, 0.4, 0.6]), found=found, bound=1)


def test_saturation_is_the_last_load_before_the_first_that_takes_three_times_as_long():
    assert curve(10, 12, 15, 32.9, 33.1).saturation == 0.4
    assert curve(10, 12, np.inf, 20, 20).saturation == 0.01
    assert curve(10, 12, 13, 14, 15).saturation == 0.6


def test_networks_stand_side_by_side():
    one, two = (Case(side=4, topology="mesh", channels=channels, traffic="uniform", length=1) for channels in (1, 2))
    torus = Case(side=4, topology="torus", channels=2, traffic="uniform", length=1)
    curves = {one: curve(10, 12, 15, 32.9, 33.1), two: curve(10, 12, 13, 14, 15), torus: curve(9, 9, 9, 9, 9)}
    row, = saturations(curves)
    assert row == ["4 x 4, uniform, 1", "11.0 (12.5)", "0.400 (0.660)", "0.600 (0.749)", "", "0.600", ""]
    between = np.array([[9, 8, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]])
    assert links({("lobby", 4): between}) == [["lobby", 4, *["1.00, 1.000"] * 5]]
