"""Messages of clusters are merged by patch, one a cycle at each node."""

import numpy as np

from radiosity.machines.paper.merge_tree import MergeTree, Messages


def messages(*rows):
    return Messages(*(np.array(value, dtype=np.int64) for value in zip(*rows, strict=True))) if rows else Messages(
        *(np.empty(0, dtype=np.int64) for _ in range(3)))


def test_sums_of_one_patch_are_added():
    merged, end = MergeTree(levels=1).merge([messages((2, 10, 4), (7, 1, 5)), messages((2, 5, 9), (3, 2, 10))], [5, 10])
    assert (merged.patch.tolist(), merged.sum.tolist()) == ([2, 3, 7], [15, 2, 1])
    assert merged.time.tolist() == [10, 11, 12]
    assert end == 12


def test_a_message_waits_until_no_smaller_patch_can_follow():
    merged, _ = MergeTree(levels=1).merge([messages((2, 1, 4)), messages((9, 1, 30))], [4, 30])
    assert merged.time.tolist() == [31, 32]
    merged, end = MergeTree(levels=1).merge([messages((2, 1, 4)), messages()], [4, 50])
    assert (merged.time.tolist(), end) == ([51], 51)


def test_a_node_is_busy_with_the_frustum_before():
    tree = MergeTree(levels=1)
    tree.merge([messages((2, 1, 40)), messages((2, 1, 40))], [40, 40])
    merged, _ = tree.merge([messages((5, 1, 10)), messages((6, 1, 10))], [10, 10])
    assert merged.time.tolist() == [42, 43]
    assert tree.messages == 3


def test_one_cluster_has_no_node():
    merged, end = MergeTree(levels=0).merge([messages((2, 1, 4), (3, 1, 5))], [5])
    assert (merged.time.tolist(), end) == ([4, 5], 5)


def test_sums_of_eight_clusters():
    rng, streams = np.random.default_rng(2), []
    for _ in range(8):
        patch = np.sort(rng.choice(40, 12, replace=False))
        streams.append(Messages(patch, rng.integers(1, 99, 12), np.arange(12) + rng.integers(0, 30)))
    merged, end = MergeTree(levels=3).merge(streams, [int(stream.time[-1]) for stream in streams])
    total = np.zeros(40, dtype=np.int64)
    for stream in streams:
        total[stream.patch] += stream.sum
    assert np.array_equal(merged.patch, np.flatnonzero(total))
    assert np.array_equal(merged.sum, total[merged.patch])
    assert (np.diff(merged.time) > 0).all()
    assert end >= max(stream.time[-1] for stream in streams) + 3
