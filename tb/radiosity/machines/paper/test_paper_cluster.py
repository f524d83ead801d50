"""The events of a cluster, from works that are made by hand."""

import numpy as np
import pytest

from radiosity.machines.paper.agenda import Agenda
from radiosity.machines.paper.cluster_memory import ClusterMemory
from radiosity.machines.paper.paper_cluster import PaperCluster
from radiosity.machines.paper.section_work import PatchWork, SectionWork, SubshellWork
from tb.radiosity.machines.paper.timings import TIMING, changed

# From the first cell of a subshell of one step to the end of the test of one ray.
PATCH = TIMING.resident + TIMING.vertices + TIMING.setup + 1 + TIMING.pipeline


def patch(number, *tests, rays=None, entries=1):
    return PatchWork(patch=number, entries=entries, rays=sum(count for _, count in tests) if rays is None else rays,
                     tests=tests)


def subshell(shell, *patches, needs=(), sector=0, scanned=0, steps=1, entries=0):
    return SubshellWork(sector=sector, shell=shell, scanned=scanned, steps=steps, needs=needs, entries=entries,
                        patches=patches)


def cast(*subshells, timing=TIMING, frusta=1, rays=9, named=None, begin=0):
    """A cluster that has cast a work some times; all patches are resident."""
    agenda = Agenda()
    held = {one.patch for sub in subshells for one in sub.patches}
    memory = ClusterMemory(agenda, timing, named=named, resident=frozenset(held), held=held, cache=None, request=print)
    work = SectionWork(subshells=subshells, extents=())
    cluster = PaperCluster(agenda, timing, memory, works=[work] * frusta, rays=rays, begin=begin)
    agenda.run()
    return cluster.counts


def test_a_patch_takes_the_latencies_of_all_units():
    counts = cast(subshell(1, patch(3, (0, 1))))
    assert counts.ends == [1 + TIMING.traversal + PATCH]
    assert (counts.tests, counts.steps, counts.patches) == (1, 1, 1)


@pytest.mark.parametrize(("changes", "more"), [({"steps": 9}, 8), ({"scanned": 6}, 5), ({"scanned": 6, "steps": 9}, 8)])
def test_traversal_takes_its_grid_rays_or_its_steps(changes, more):
    one = cast(subshell(1, patch(3, (0, 1)))).ends[0]
    assert cast(subshell(1, patch(3, (0, 1)), **changes)).ends == [one + more]


def test_a_list_is_read_an_entry_a_cycle():
    one = cast(subshell(1, patch(3, (0, 1)))).ends[0]
    assert cast(subshell(1, patch(3, (0, 1), entries=20))).ends == [one + 20 - 1 - TIMING.traversal]
    assert cast(subshell(1, patch(3, (0, 1)), entries=200)).ends == [1 + TIMING.traversal + 200]


def test_each_ray_of_a_window_is_checked_and_tested_if_it_has_not_hit():
    one = cast(subshell(1, patch(3, (0, 1)))).ends[0]
    assert cast(subshell(1, patch(3, (0, 8)))).ends == [one + 7]
    assert cast(subshell(1, patch(3, (0, 1), rays=8))).ends == [one + 7]
    assert cast(subshell(1, patch(3, (0, 8)), patch(4, (0, 8)))).ends == [one + 15]


def test_a_shell_follows_when_its_rays_have_left_the_one_before():
    one = cast(subshell(1, patch(3, (0, 1)))).ends[0]
    assert cast(subshell(1, patch(3, (0, 1))), subshell(2, patch(4, (1, 1)), needs=(0,))).ends == [2 * one]


def wavefront(*needs):
    """A slow and a fast subshell in shell 1, of two sectors; in shell 2 the fast one goes on with what it needs."""
    return (subshell(1, steps=300), subshell(1, sector=1), subshell(2, needs=(0,)),
            subshell(2, patch(4, (3, 400)), needs=needs, sector=1))


def test_subshells_of_two_shells_are_in_flight():
    """The second shell's long tests run beside the first shell."""
    alone, barrier = cast(*wavefront(1)).ends[0], cast(*wavefront(0, 1)).ends[0]
    assert barrier == 300 + 1 + 2 * TIMING.traversal + PATCH + 399
    assert alone == 1 + 1 + 2 * TIMING.traversal + PATCH + 399


def test_a_shell_waits_for_the_end_of_the_one_two_before():
    """Its windows size the subshells; the last subshell needs a short one alone."""
    last = subshell(3, patch(5, (4, 1)), needs=(3,), sector=1)
    shells = subshell(1, steps=500), subshell(1, sector=1), subshell(2, needs=(0,)), subshell(2, needs=(1,), sector=1)
    assert cast(*shells, last).ends == [500 + 1 + 2 * TIMING.traversal + PATCH]


def deferring(rays):
    """A patch of the second shell, found while some of its rays are still in the first one."""
    return (subshell(1, steps=400), subshell(1, sector=1), subshell(2, needs=(0,)),
            subshell(2, patch(2, (2, rays), (3, 5)), needs=(1,), sector=1))


def test_rays_without_presence_are_deferred():
    counts = cast(*deferring(30))
    assert (counts.deferred, counts.most_deferred, counts.parked) == (30, 30, 0)
    # Their tests follow the end of the first shell.
    assert counts.ends == [400 + TIMING.traversal + 30 + TIMING.pipeline]
    assert cast(*deferring(40)).ends == [counts.ends[0] + 10]
    present = list(deferring(30))
    present[2] = subshell(2, needs=(1,))
    assert cast(*present).deferred == 0


@pytest.mark.parametrize("deferred", [0, 29, 30])
def test_rays_beyond_the_deferred_ray_memory_are_checked_twice(deferred):
    counts = cast(*deferring(30), timing=changed(deferred=deferred))
    assert (counts.deferred, counts.parked) == ((30, 0) if deferred == 30 else (0, 30))
    assert counts.tests == 35
    assert len(counts.ends) == 1


def test_frusta_follow_each_other_after_the_read_out():
    once, thrice = cast(subshell(1, patch(3, (0, 1)))), cast(subshell(1, patch(3, (0, 1))), frusta=3, begin=5)
    assert thrice.ends == [5 + once.ends[0] * (1 + number) + 9 * number for number in range(3)]
    assert thrice.tests == 3


def test_patches_that_tags_send_elsewhere_are_skipped():
    counts = cast(subshell(1, patch(3, (0, 1)), patch(4, rays=0)), named=frozenset([3]))
    assert (counts.patches, counts.skipped) == (1, 1)
    with pytest.raises(RuntimeError, match="Patch 3 has tests in a section that its tag does not name"):
        cast(subshell(1, patch(3, (0, 1))), named=frozenset())


def test_drawn_works_end_with_all_tests():
    """No deadlock, whatever the capacity of the deferred-ray memory."""
    rng = np.random.default_rng(4)
    for _ in range(20):
        subshells, before = [], []
        for shell in range(1, 6):
            own = range(len(subshells), len(subshells) + int(rng.integers(1, 7)))
            for number in own:
                found = []
                for index in range(rng.integers(0, 4)):
                    where = rng.choice(own, rng.integers(0, len(own) + 1), replace=False).tolist()
                    found.append(patch(10 * number + index, *((one, int(rng.integers(1, 20))) for one in where)))
                needs = rng.choice(before, rng.integers(1, len(before) + 1), replace=False) if before else ()
                subshells.append(subshell(shell, *found, needs=tuple(map(int, needs)), sector=(number - own[0]) % 2,
                                          steps=int(rng.integers(0, 9))))
            before = list(own)
        expected = sum(count for one in subshells for found in one.patches for _, count in found.tests)
        for deferred in (0, 10, 1000):
            counts = cast(*subshells, timing=changed(deferred=deferred))
            assert (len(counts.ends), counts.tests) == (1, expected)
