import pytest

from hw.lib.queue import Queue
from tb.formal.source_fault import source_fault, with_parts


def test_only_the_class_that_is_returned_has_the_fault():
    wrong = source_fault(Queue, "self.latency = 1", "self.latency = 2")
    assert (wrong(8, depth=2).latency, Queue(8, depth=2).latency) == (2, 1)


@pytest.mark.parametrize(("right", "times"), [("no such text", 0), ("level", "[1-9]")])
def test_text_must_stand_once(right, times):
    with pytest.raises(ValueError, match=f"^Text must stand once in the source of Queue, not {times}"):
        source_fault(Queue, right, "")


def test_only_the_class_that_is_returned_has_other_parts():
    wrong = with_parts(Queue, Memory="another")
    assert wrong.elaborate.__globals__["Memory"] == "another"
    assert Queue.elaborate.__globals__["Memory"] != "another"


def test_parts_must_be_of_the_module():
    with pytest.raises(ValueError, match=r"^Part must be one of hw\.lib\.queue, not Memories$"):
        with_parts(Queue, Memories=1)
