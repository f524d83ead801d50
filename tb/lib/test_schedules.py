import pytest
from amaranth.hdl import Module, Mux
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out
from hypothesis import find, given
from hypothesis import strategies as st

from hw.lib.payload import pack, unpack
from hw.lib.queue import Queue
from tb.formal.negative_control import NegativeControl
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench, payloads, schedules

SHAPE = StructLayout({"number": 4, "inverted": 4})


def fails(bench):
    """Whether a schedule shows a fault."""
    def shown(schedule):
        try:
            return bench.run(schedule) != {"o": schedule.values("i")}
        except AssertionError:
            return True

    return shown


def smallest(component):
    """The smallest schedule that shows a fault, as Hypothesis finds it."""
    drawn = schedules({"i": payloads(SHAPE)}, ["o"], most=8)
    return find(drawn, fails(ScheduleBench(component, ["i"], ["o"])), settings=SETTINGS)


ZERO = {"number": 0, "inverted": 0}


@pytest.mark.nightly
def test_a_full_queue_that_takes_shrinks_to_hardly_more_than_it_holds():
    found = smallest(NegativeControl(Queue(SHAPE, depth=3), {"i__ready": lambda dut: 1}))
    # Hypothesis gives up after a number of attempts without progress: an item or two more than the least may stay.
    assert found.values("i") in [[ZERO] * count for count in range(4, 9)]
    assert sum(idle for idle, _ in found.items["i"]) == 0
    assert 1 <= len(found.stalls["o"]) <= 2


@pytest.mark.nightly
def test_one_wrong_bit_shrinks_to_the_number_that_shows_it():
    found = smallest(NegativeControl(Queue(SHAPE, depth=3), {
        "o__payload": lambda dut: Mux(dut.o.payload.number >= 11, 0, dut.o.payload.as_value())}))
    *others, last = found.items["i"]
    assert last == (0, {"number": 11, "inverted": 0})
    assert others in [[(0, ZERO)] * count for count in range(4)]
    assert found.stalls["o"] == []


class Refuses(wiring.Component):
    """Takes nothing and gives nothing."""

    def __init__(self):
        super().__init__({"i": In(stream.Signature(SHAPE)), "o": Out(stream.Signature(SHAPE))})

    def elaborate(self, platform):
        return Module()


def broken_queue(**faults):
    return NegativeControl(Queue(SHAPE, depth=3), faults)


@pytest.mark.parametrize(("component", "message"), [
    (broken_queue(o__valid=lambda dut: dut.o.valid & ~dut.i.valid), "o: an offer must stay until it is accepted"),
    (broken_queue(o__payload=lambda dut: dut.o.payload.as_value() ^ dut.i.valid),
     "o: an offer must not change until it is accepted"),
    # Inside it takes the same item for ever.
    (broken_queue(i__ready=lambda dut: 0), "the run does not end within 3000 cycles"),
    (Refuses(), r"items were never accepted: \{'i': 2\}")], ids=["withdrawn", "changed", "endless", "refused"])
def test_faults_are_named(component, message):
    bench = ScheduleBench(component, ["i"], ["o"])
    schedule = Schedule(items={"i": [(0, ZERO), (2, ZERO)]}, stalls={"o": [8]})
    with pytest.raises(AssertionError, match=f"^{message}"):
        bench.run(schedule)


def test_a_run_leaves_nothing_to_the_next_one():
    bench = ScheduleBench(Queue(SHAPE, depth=3), ["i"], ["o"])
    for number in (3, 5):
        items = [(0, {"number": number, "inverted": k}) for k in range(number)]
        assert len(bench.run(Schedule(items={"i": items}, stalls={}))["o"]) == number


@SETTINGS
@given(st.data())
def test_payloads_are_all_of_a_shape(data):
    shape = StructLayout({"a": ArrayLayout(StructLayout({"b": 3}), 2), "c": 1})
    value = data.draw(payloads(shape))
    assert unpack(shape, pack(shape, value)) == value


def test_a_bench_goes_on_after_a_run_that_has_failed():
    bench = ScheduleBench(Queue(SHAPE, depth=3), idle_limit=16, watchdog=20)
    given = Schedule(items={"i": [(9, ZERO)] * 4}, stalls={})
    with pytest.raises(AssertionError, match="does not end within 20 cycles"):
        bench.run(given)
    assert bench.run(Schedule(items={"i": [(0, ZERO)]}, stalls={})) == {"o": [ZERO]}
