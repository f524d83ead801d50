"""Events leave the heap by time, and by the order of scheduling at one time."""

import heapq

import numpy as np
import pytest

from radiosity.machines.common.event_heap import event_heap, next_time, pop, push

pytestmark = pytest.mark.usefixtures("interpreted")


def test_events_leave_in_the_order_of_time_and_scheduling():
    """As those of Python's heap; times are few, so that many are equal."""
    random, heap, expected = np.random.default_rng(1), event_heap(200), []
    for number in range(2000):
        if expected and (len(expected) == 200 or random.random() < 0.5 * (1 + (number > 1500))):
            time, _, kind, subject = heapq.heappop(expected)
            assert next_time(heap) == time
            assert pop(heap) == (time, kind, subject)
        else:
            event = int(random.integers(0, 12)), int(random.integers(0, 5)), number
            push(heap, *event)
            heapq.heappush(expected, (event[0], number, *event[1:]))
    assert [pop(heap) for _ in range(len(expected))] == [
        (time, kind, subject) for time, _, kind, subject in sorted(expected)]
    assert next_time(heap) == -1


def test_a_full_and_an_empty_heap_are_refused():
    heap = event_heap(1)
    with pytest.raises(IndexError, match="at least 1 when one is taken"):
        pop(heap)
    push(heap, 3, 1, 2)
    with pytest.raises(OverflowError, match="at most the capacity"):
        push(heap, 4, 1, 2)
    assert pop(heap) == (3, 1, 2)


@pytest.mark.parametrize(("capacity", "error", "message"), [
    (0, ValueError, "Capacity must be at least 1, not 0"), (True, TypeError, "Capacity must be an int, not True")])
def test_a_capacity_out_of_range_is_refused(capacity, error, message):
    with pytest.raises(error, match=message):
        event_heap(capacity)
