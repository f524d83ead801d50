"""A reference looks into the resident set, then into the cache, then into main memory."""

import pytest

from golden.engine.memsys.bus.cache import Cache
from golden.engine.memsys.bus.cache_policy import CachePolicy
from radiosity.machines.paper.agenda import Agenda
from radiosity.machines.paper.cluster_memory import ClusterMemory
from tb.radiosity.machines.paper.timings import TIMING


class Bench:
    """A memory whose requests and answers are noted."""

    def __init__(self, *, named=None, resident=(), held=(), lines=0):
        self.agenda, self.requests, self.times = Agenda(), [], {}
        self.memory = ClusterMemory(
            self.agenda, TIMING, named=named, resident=frozenset(resident), held=set(held),
            cache=Cache(CachePolicy.DIRECT, lines=lines) if lines else None,
            request=lambda patch: self.requests.append((self.agenda.now, patch)))

    def refer(self, time, patch):
        self.agenda.at(time, self.memory.refer, patch, lambda: self.times.setdefault(patch, self.agenda.now))


def test_levels_are_looked_up_in_their_order():
    bench = Bench(resident=[1], held=[1], lines=4)
    bench.memory.refer(2, print)
    bench.memory.answer(2)
    bench.refer(20, 1)
    bench.refer(20, 2)
    bench.refer(20, 3)
    bench.agenda.at(50, bench.memory.answer, 3)
    bench.agenda.run()
    assert bench.times == {1: 22, 2: 25, 3: 52}
    assert bench.requests == [(0, 2), (20, 3)]
    assert (bench.memory.residents, bench.memory.hits, bench.memory.misses) == (1, 1, 2)


def test_a_resident_patch_is_awaited_and_not_requested():
    bench = Bench(resident=[1], lines=4)
    bench.refer(3, 1)
    bench.agenda.at(30, bench.memory.accept, 1)
    bench.refer(40, 1)
    bench.agenda.run()
    assert bench.times == {1: 32}
    assert not bench.requests
    assert bench.memory.residents == 2


def test_patches_outstanding_are_limited():
    bench = Bench()
    for patch in range(4):
        bench.refer(patch, patch)
    bench.agenda.at(20, bench.memory.answer, 1)
    bench.agenda.at(30, bench.memory.answer, 0)
    bench.agenda.run()
    assert bench.requests == [(0, 0), (1, 1), (20, 2), (30, 3)]
    assert bench.times == {1: 22, 0: 32}


def test_a_patch_that_is_not_resident_is_dropped():
    bench = Bench(resident=[1], lines=4)
    bench.refer(0, 5)
    bench.agenda.at(3, bench.memory.accept, 5)
    bench.agenda.at(30, bench.memory.answer, 5)
    bench.agenda.run()
    assert bench.memory.dropped == 1
    assert bench.times == {5: 32}


@pytest.mark.parametrize(("named", "expected"), [(None, True), (frozenset([7]), True), (frozenset([8]), False)])
def test_tags_name_the_patches_of_a_cluster(named, expected):
    assert Bench(named=named).memory.names(7) is expected


def test_patches_that_arrive_are_received_once_and_kept_ones_are_not():
    bench = Bench(resident=[1, 2], held=[1])
    bench.memory.accept(2)
    bench.memory.accept(3)
    bench.refer(0, 1)
    bench.refer(0, 4)
    bench.agenda.at(20, bench.memory.answer, 4)
    bench.agenda.run()
    assert (bench.memory.received, bench.memory.dropped) == (2, 1)
