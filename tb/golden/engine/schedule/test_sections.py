"""Sections cover the frustum, and balance what can be balanced."""

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.engine.schedule.sections import cut_sections

CLUSTERS = [1, 2, 4, 8, 16, 64]


def workload(seed, rows=16, columns=64):
    random = np.random.default_rng(seed)
    return random.integers(0, 5, (rows, columns)) * 10.0 ** random.integers(0, 3, (rows, 1))


@pytest.mark.parametrize("clusters", CLUSTERS)
@pytest.mark.parametrize("seed", range(4))
def test_every_ray_is_in_exactly_one_section(clusters, seed):
    partition = cut_sections(workload(seed), clusters=clusters)
    count = np.zeros((16, 64), dtype=int)
    for number, section in enumerate(partition.sections):
        part = slice(section.first_row, section.end_row), slice(section.first_column, section.end_column)
        count[part] += 1
        assert (partition.cluster_map[part] == number).all()
    assert len(partition.sections) == clusters
    assert (count == 1).all()


@pytest.mark.parametrize("clusters", CLUSTERS)
def test_uniform_work_is_cut_in_equal_sections(clusters):
    sums = cut_sections(np.ones((16, 64)), clusters=clusters).sums(np.ones((16, 64)))
    assert (sums == 1024 / clusters).all()


def test_no_border_is_nearer_to_the_median_than_the_one_cut_at():
    work = workload(7)
    partition = cut_sections(work, clusters=4)
    first = partition.levels[1][0][1]
    off = [abs(work[:, :at].sum() - work.sum() / 2) for at in range(1, 64)]
    assert off[first - 1] == min(off)
    for side, (low, _) in zip(partition.levels[1], partition.levels[2].reshape(2, 2, 4), strict=True):
        part = work[:, side[0]:side[1]]
        off = [abs(part[:at].sum() - part.sum() / 2) for at in range(1, 16)]
        assert off[low[3] - 1] == min(off)


def test_cuts_alternate_between_azimuth_and_polar_angle():
    levels = cut_sections(workload(3), clusters=16).levels
    for level in range(4):
        for part, (low, high) in zip(levels[level], levels[level + 1].reshape(-1, 2, 4), strict=True):
            cut = slice(0, 2) if level % 2 == 0 else slice(2, 4)
            kept = slice(2, 4) if level % 2 == 0 else slice(0, 2)
            assert np.array_equal(low[kept], part[kept])
            assert np.array_equal(high[kept], part[kept])
            assert (low[cut][0], low[cut][1], high[cut][1]) == (part[cut][0], high[cut][0], part[cut][1])


def test_without_work_the_sections_are_equal():
    partition = cut_sections(np.zeros((8, 32)), clusters=8)
    assert (partition.sums(np.ones((8, 32))) == 32).all()


def test_all_work_in_one_ray_still_leaves_every_cluster_rays():
    work = np.zeros((8, 32))
    work[0, 0] = 1
    assert cut_sections(work, clusters=64).sums(np.ones((8, 32))).min() >= 1


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("rows", "columns"), [(16, 64), (31, 50), (13, 29)])
def test_no_section_exceeds_the_ray_capacity(seed, rows, columns):
    for clusters in 2, 4, 8, 16:
        cuts = clusters.bit_length() - 1
        smallest = -(-rows // (1 << cuts // 2)) * -(-columns // (1 << (cuts + 1) // 2))
        for ray_capacity in smallest, max(smallest, int(1.4 * rows * columns / clusters)):
            partition = cut_sections(workload(seed, rows, columns), clusters=clusters, ray_capacity=ray_capacity)
            assert partition.sums(np.ones((rows, columns))).max() <= ray_capacity


def test_a_capacity_below_equal_sections_is_refused():
    with pytest.raises(InputError, match=r"64 x 16 rays on 4 clusters .* at least 256 rays.*capacity is 255"):
        cut_sections(np.ones((16, 64)), clusters=4, ray_capacity=255)


def test_input_that_makes_no_sections_is_refused_by_name():
    for clusters in 0, 3:
        with pytest.raises(InputError, match="Clusters must be a power of two"):
            cut_sections(np.ones((4, 4)), clusters=clusters)
    for clusters in 2.0, True:
        with pytest.raises(TypeError, match="Clusters must be an int"):
            cut_sections(np.ones((4, 4)), clusters=clusters)
    with pytest.raises(InputError, match="4 x 4 rays cannot be cut for 32 clusters"):
        cut_sections(np.ones((4, 4)), clusters=32)
    for bad in np.full((4, 4), -1.0), np.full((4, 4), np.nan), np.ones(4), np.ones((0, 4)):
        with pytest.raises(InputError, match="Workload must be finite and at least 0"):
            cut_sections(bad, clusters=2)
