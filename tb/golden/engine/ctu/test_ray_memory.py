"""Each grid ray is issued once per shell, one copy at a time, and no request is lost."""

import numpy as np

from golden.engine.ctu.ray_memory import RayMemory


def test_a_present_ray_is_issued_once_per_shell():
    memory = RayMemory(4, deferred=4)
    issued, accepted = memory.request(np.array([2, 0]), subshell=0, shell=2)
    assert (issued.tolist(), accepted) == ([2, 0], 2)
    memory.complete(issued)
    assert memory.request(np.array([0, 1, 2]), subshell=1, shell=2)[0].tolist() == [1]


def test_the_same_request_is_skipped_also_while_the_ray_is_in_flight():
    memory = RayMemory(1, deferred=1)
    memory.request(np.array([0]), subshell=0, shell=3)
    issued, accepted = memory.request(np.array([0]), subshell=1, shell=3)
    assert (issued.tolist(), accepted, memory.waiting) == ([], 1, [])


def test_a_request_for_an_absent_ray_waits_and_is_released_once():
    memory = RayMemory(2, deferred=2)
    memory.request(np.array([0]), subshell=0, shell=2)
    assert memory.request(np.array([0, 1]), subshell=5, shell=3)[0].tolist() == [1]
    assert memory.complete(np.array([1])) == []
    assert memory.complete(np.array([0])) == [(0, 5, 3)]
    assert memory.complete(np.array([0])) == []
    assert memory.waiting == []


def test_of_two_waiting_requests_for_one_version_the_later_is_skipped():
    memory = RayMemory(1, deferred=3)
    memory.request(np.array([0]), subshell=0, shell=2)
    memory.request(np.array([0]), subshell=1, shell=3)
    memory.request(np.array([0]), subshell=2, shell=3)
    memory.request(np.array([0]), subshell=3, shell=4)
    assert memory.complete(np.array([0])) == [(0, 1, 3)]
    assert memory.complete(np.array([0])) == [(0, 3, 4)]
    assert memory.complete(np.array([0])) == []


def test_a_full_store_stalls_the_subshell_at_its_request():
    memory = RayMemory(5, deferred=1)
    memory.request(np.array([1, 3]), subshell=0, shell=2)
    issued, accepted = memory.request(np.array([0, 1, 2, 3, 4]), subshell=1, shell=3)
    assert (issued.tolist(), accepted) == ([0, 2], 3)
    assert memory.waiting == [(1, 1, 3)]
    assert memory.complete(np.array([1, 3])) == [(1, 1, 3)]
    issued, accepted = memory.request(np.array([3, 4]), subshell=1, shell=3)
    assert (issued.tolist(), accepted) == ([3, 4], 2)


def test_random_traffic_sends_each_slot_once_per_shell_and_never_two_copies():
    random = np.random.default_rng(4)
    memory = RayMemory(12, deferred=1000)
    away, sent, requested = set(), [], set()

    def leave(slots, shell):
        for slot in slots:
            assert slot not in away
            away.add(slot)
            sent.append((slot, shell))

    for time in range(400):
        shell = 2 + time // 50
        slots = random.choice(12, 4, replace=False)
        requested |= {(int(slot), shell) for slot in slots}
        leave(memory.request(slots, subshell=time, shell=shell)[0].tolist(), shell)
        back = [slot for slot in sorted(away) if random.random() < 0.4]
        away -= set(back)
        for slot, _, version in memory.complete(np.array(back, dtype=np.int64)):
            leave([slot], version)
    while away:
        back, away = sorted(away), set()
        for slot, _, version in memory.complete(np.array(back, dtype=np.int64)):
            leave([slot], version)
    assert len(sent) == len(set(sent))
    assert set(sent) <= requested
    # A ray not sent was requested while a later shell's request was first to be released.
    assert len(sent) > 0.9 * len(requested)
    assert memory.waiting == []
