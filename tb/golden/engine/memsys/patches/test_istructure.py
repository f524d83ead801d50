"""Every read is answered once, with the data of its version, in any order of reads and writes."""

import numpy as np
import pytest

from golden.engine.memsys.patches.istructure import IStructure
from tb.memsys.patches.any_order import answers


def test_a_location_is_written_once():
    memory = IStructure(2, deferred=1)
    assert memory.write(1, 7) == (True, [])
    assert memory.write(1, 8) == (False, [])
    assert memory.read(1, 0) == (True, [0])
    assert memory.value(1) == 7


def test_reads_of_an_empty_location_wait_and_are_answered_once():
    memory = IStructure(2, deferred=4)
    assert [memory.read(0, tag) for tag in (5, 3, 4)] == [(True, [])] * 3
    assert memory.write(1, 1) == (True, [])
    assert memory.write(0, 2) == (True, [5, 3, 4])
    assert memory.write(0, 2) == (False, [])
    assert memory.waiting == {}


def test_a_full_store_stalls_reads_that_would_wait_and_nothing_else():
    memory = IStructure(3, deferred=1)
    memory.write(2, 9)
    assert memory.read(0, 1) == (True, [])
    assert memory.read(1, 2) == (False, [])
    assert memory.read(2, 3) == (True, [3])
    assert memory.write(1, 4) == (True, [])
    assert memory.read(1, 2) == (True, [2])


def test_a_version_begins_empty_and_not_while_reads_wait():
    memory = IStructure(2, deferred=2)
    memory.write(0, 6)
    memory.read(1, 1)
    assert not memory.start()
    memory.write(1, 6)
    assert memory.start()
    assert memory.value(0) is None
    assert memory.write(0, 5) == (True, [])


@pytest.mark.parametrize("seed", range(5))
def test_the_answers_do_not_depend_on_the_order(seed):
    random = np.random.default_rng(seed)
    reads, writes = random.integers(10, size=40), random.integers(10, size=12)
    data = random.integers(1, 1000, size=len(writes))
    answered, values, refused = answers(reads, writes, data)
    assert answered.any()
    assert refused.any()
    for _ in range(10):
        # Writes among each other keep their order.
        kinds = random.permutation(np.repeat([True, False], [len(reads), len(writes)]))
        memory, found, not_taken = IStructure(10, deferred=100), {}, []
        read, write = iter(random.permutation(len(reads)).tolist()), iter(range(len(writes)))
        for is_read in kinds:
            if is_read:
                number = next(read)
                address, (_, tags) = int(reads[number]), memory.read(int(reads[number]), number)
            else:
                number = next(write)
                address = int(writes[number])
                taken, tags = memory.write(address, int(data[number]))
                not_taken.append(not taken)
            for tag in tags:
                assert tag not in found
                found[tag] = memory.value(address)
        assert found == {int(number): int(values[number]) for number in np.flatnonzero(answered)}
        assert not_taken == refused.tolist()
        assert memory.level == (~answered).sum()


def test_nothing_written_answers_nothing():
    answered, values, refused = answers(np.array([1, 2]), np.array([], dtype=int), np.array([], dtype=int))
    assert not answered.any()
    assert not values.any()
    assert not len(refused)
