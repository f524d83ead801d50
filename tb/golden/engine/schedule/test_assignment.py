"""Assignment to the processors of a network."""

import numpy as np
import pytest

from golden.engine.noc.topology import Topology
from golden.engine.schedule.assignment import heaviest_to_nearest, mean_hops, traffic
from golden.engine.schedule.classification import classify
from golden.engine.schedule.sections import cut_sections
from tb.golden.engine.schedule.windows import random_windows


def random_load(seed, clusters):
    load = np.random.default_rng(seed).integers(0, 50, (clusters, clusters))
    load[load < 25] = 0
    np.fill_diagonal(load, 0)
    return load + load.T


@pytest.mark.parametrize("topology", ["mesh", "torus", "ring", "illiac", "hypercube"])
@pytest.mark.parametrize("seed", range(5))
def test_each_processor_gets_one_cluster(topology, seed):
    for clusters in 1, 2, 8, 16:
        processor = heaviest_to_nearest(random_load(seed, clusters), Topology.of(topology, clusters).hops)
        assert sorted(processor) == list(range(clusters))


def test_the_heaviest_pairs_become_neighbours():
    # A chain of traffic 0 - 3 - 1 - 2 fits a ring link by link.
    load = np.zeros((4, 4), dtype=int)
    for first, second, weight in (0, 3, 9), (3, 1, 5), (1, 2, 7):
        load[first, second] = load[second, first] = weight
    distance = Topology.of("ring", 4).hops
    processor = heaviest_to_nearest(load, distance)
    assert mean_hops(load, distance, processor) == 1
    assert mean_hops(load, distance, np.arange(4)) > 1


def test_the_first_cluster_gets_the_most_links():
    load = random_load(3, 16)
    processor = heaviest_to_nearest(load, Topology.of("mesh", 16).hops)
    assert processor[np.argmax(load.sum(axis=1))] == 5


def test_without_traffic_everyone_is_placed_in_order_of_links():
    processor = heaviest_to_nearest(np.zeros((8, 8), dtype=int), Topology.of("mesh", 8).hops)
    assert sorted(processor[:4]) == [1, 2, 5, 6]


def test_traffic_counts_each_patch_once_for_each_section_away_from_home():
    partition = cut_sections(np.random.default_rng(4).random((16, 64)), clusters=8)
    window = random_windows(64, 16, seed=9)
    home = classify(partition, window)
    expected = np.zeros((8, 8), dtype=int)
    which, column, row = window.pairs(64)
    for patch, section in set(zip(which.tolist(), partition.cluster_map[row, column].tolist(), strict=True)):
        if section != home[patch]:
            expected[section, home[patch]] += 1
    assert expected.any()
    assert np.array_equal(traffic(partition, window, home), expected + expected.T)
