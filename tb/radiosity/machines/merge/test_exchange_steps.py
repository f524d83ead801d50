"""Who sends which regions to whom: neighbours alone, and each region to its node in the end."""

import numpy as np
import pytest

from golden.base.errors import InputError
from radiosity.machines.merge.exchange_steps import dimensions_of, mesh_steps, partners

MESHES = [(16,), (4, 4), (8, 2), (2, 8), (2, 2, 2, 2), (4, 2, 2)]


@pytest.mark.parametrize("sides", MESHES)
def test_neighbours_exchange_and_each_region_comes_to_one_node(sides):
    steps = mesh_steps(sides)
    assert len(steps.target) == sum(side - 1 for side in sides)
    node = np.arange(16)
    assert (np.bitwise_count(steps.target ^ node) == 1).all()
    assert (np.take_along_axis(steps.source, steps.target, axis=1) == node).all()
    assert np.array_equal(np.sort(steps.region), node)
    # What nodes hold of each region, of which the sender keeps nothing: all 16 meet in the region's node.
    held = np.zeros((16, 16, 16), dtype=bool)
    held[node, node] = True
    for target, first, last in zip(steps.target, steps.first, steps.last, strict=True):
        sent = held.copy()
        for sender in node:
            part = slice(first[sender], last[sender])
            held[sender, :, part] = False
        for sender in node:
            part = slice(first[sender], last[sender])
            held[target[sender], :, part] |= sent[sender, :, part]
    for one in node:
        assert held[one, :, steps.region[one]].all()
        assert held[one].sum() == 16


def test_a_node_at_position_k_of_a_ring_sends_part_k_plus_i_in_step_i():
    steps = mesh_steps((8,))
    around = [0, 1, 3, 2, 6, 7, 5, 4]
    for position, node in enumerate(around):
        assert steps.first[:, node].tolist() == [(position + i) % 8 for i in range(1, 8)]
        assert set(steps.target[:, node]) == {around[position - 1]}
        assert steps.region[node] == position


def test_pairs_are_neighbours_over_channel_i_in_step_i_and_halve_their_band():
    steps = mesh_steps(dimensions_of("pair", 16))
    for step in range(4):
        assert np.array_equal(steps.target[step], np.arange(16) ^ 1 << step)
        assert (steps.last[step] - steps.first[step] == 8 >> step).all()


def test_schemes_are_meshes():
    assert [dimensions_of(scheme, 32) for scheme in ("ring", "mesh", "pair")] == [(32,), (8, 4), (2,) * 5]
    assert [dimensions_of(scheme, 1) for scheme in ("ring", "mesh", "pair")] == [(), (), ()]
    with pytest.raises(InputError, match="Scheme must be one of ring, mesh, pair, aapc, not 'tree'"):
        dimensions_of("tree", 4)


@pytest.mark.parametrize("nodes", [2, 8, 32])
def test_each_exchanges_with_each_once_by_links_that_no_other_takes(nodes):
    met = np.stack([partners(nodes, step) for step in range(1, nodes)])
    assert np.array_equal(np.sort(np.concatenate([np.arange(nodes)[None], met]), axis=0),
                          np.tile(np.arange(nodes)[:, None], nodes))
    for targets in met:
        assert np.array_equal(targets[targets], np.arange(nodes))
        taken = []
        for node, target in enumerate(targets):
            at = node
            for channel in range(nodes.bit_length() - 1):
                if (at ^ target) >> channel & 1:
                    taken.append((at, channel))
                    at ^= 1 << channel
        assert len(taken) == len(set(taken))
