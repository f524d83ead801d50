import time

import pytest

from golden.spread import in_threads, in_turn, spans

PARTS = spans(23, 5)


def test_spans_cover_all_numbers_once():
    assert PARTS == [(0, 5), (5, 10), (10, 15), (15, 20), (20, 23)]
    assert spans(0, 5) == []


@pytest.mark.parametrize("spread", [in_turn, in_threads(1), in_threads(3)])
def test_each_span_comes_with_its_result(spread):
    assert dict(spread(range, PARTS)) == {part: range(*part) for part in PARTS}


def test_one_thread_computes_a_span_when_it_is_requested():
    begun = []
    results = in_threads(1)(lambda *part: begun.append(part), PARTS)
    next(results)
    assert begun == PARTS[:1]


def test_an_error_in_a_thread_ends_the_work():
    begun = []

    def work(first, last):
        begun.append(first)
        if not first:
            raise KeyboardInterrupt
        time.sleep(0.001)

    with pytest.raises(KeyboardInterrupt):
        list(in_threads(2)(work, spans(10000, 1)))
    assert len(begun) < 10000
