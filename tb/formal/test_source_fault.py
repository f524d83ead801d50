# amaranth: UnusedElaboratable=no
import pytest

from hw.lib.queue import Queue
from tb.formal.source_fault import source_fault


def test_only_the_class_that_is_returned_has_the_fault():
    wrong = source_fault(Queue, "self.latency = 1", "self.latency = 2")
    assert (wrong(8, depth=2).latency, Queue(8, depth=2).latency) == (2, 1)


@pytest.mark.parametrize(("right", "times"), [("no such text", 0), ("level", "[1-9]")])
def test_text_must_stand_once(right, times):
    with pytest.raises(ValueError, match=f"^Text must stand once in the source of Queue, not {times}"):
        source_fault(Queue, right, "")
