from itertools import pairwise, repeat

import pytest
from amaranth.lib.data import ArrayLayout, StructLayout
from hypothesis import given
from hypothesis import strategies as st

from hw.lib.time_multiplexer import TimeMultiplexer
from tb.lib.bench import Bench, Vectors
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench, payloads
from tb.lib.stages import Elastic, Expand

SHAPE = StructLayout({"number": 8, "inverted": 8})
ITEMS = [{"number": k, "inverted": ~k & 255} for k in range(60)]
COUNTS = (2, 3, 4, 5)
BENCHES = {count: ScheduleBench(TimeMultiplexer(SHAPE, count=count), ["i"], ["o"]) for count in COUNTS}


def phases(items, count):
    return [{"phase": phase, "item": item} for item in items for phase in range(count)]


class TestTimeMultiplexer(Bench):
    """Each item is shown in every phase."""

    component, variants, splits, interval = TimeMultiplexer, ({},), False, 3

    @property
    def arguments(self):
        return {"shape": SHAPE, "count": self.interval}

    def vectors(self, config):
        return Vectors(inputs={"i": ITEMS}, expected={"o": phases(ITEMS, self.interval)})

    def stages(self, component, config):
        return [Elastic(component.latency), Expand(repeat(self.interval))]


@pytest.mark.parametrize("count", COUNTS)
def test_other_counts(count):
    bench = TestTimeMultiplexer()
    bench.interval = count
    bench.test_in_amaranth({})


@SETTINGS
@given(st.sampled_from(COUNTS), st.lists(st.tuples(st.integers(0, 6), payloads(SHAPE)), max_size=12))
def test_any_stalls(count, given_items):
    # At least as many cycles apart as there are phases.
    items = [(idle + (count - 1 if number else 0), item) for number, (idle, item) in enumerate(given_items)]
    came = BENCHES[count].run(Schedule(items={"i": items}, stalls={}))
    assert came == {"o": phases([item for _, item in items], count)}


def test_phases_some_cycles_apart():
    bench = ScheduleBench(TimeMultiplexer(SHAPE, count=3, interval=4), ["i"], ["o"])
    came = bench.run(Schedule(items={"i": [(11 + 5 * (number == 3), item) for number, item in enumerate(ITEMS[:5])]},
                              stalls={}))
    assert came == {"o": phases(ITEMS[:5], 3)}
    assert [b - a for a, b in pairwise(bench.cycles["o"])] == [4] * 8 + [9] + [4] * 5


def test_turned_field_begins_with_the_element_of_the_phase():
    shape = StructLayout({"name": 8, "parts": ArrayLayout(8, 3)})
    items = [{"name": number, "parts": [3 * number + k for k in range(3)]} for number in range(20)]
    for interval in (1, 4):
        bench = ScheduleBench(TimeMultiplexer(shape, count=3, interval=interval, turned="parts"), ["i"], ["o"])
        came = bench.run(Schedule(items={"i": [(3 * interval - 1, item) for item in items]}, stalls={}))
        assert came == {"o": [
            {"phase": phase, "item": item | {"parts": [item["parts"][(phase + k) % 3] for k in range(3)]}}
            for item in items for phase in range(3)]}


def test_init_wrong_interval():
    with pytest.raises(ValueError, match=r"^Interval must be at least 1, not 0$"):
        TimeMultiplexer(SHAPE, count=2, interval=0)


def test_init_wrong_count():
    with pytest.raises(ValueError, match=r"^Count must be at least 2, not 1$"):
        TimeMultiplexer(SHAPE, count=1)


def test_a_field_that_turns_begins_with_the_own_element_of_each_phase():
    shape = StructLayout({"parts": ArrayLayout(8, 3), "number": 8})
    bench = ScheduleBench(TimeMultiplexer(shape, count=3, turned="parts"), ["i"], ["o"])
    items = [{"parts": [10 * k, 10 * k + 1, 10 * k + 2], "number": k} for k in range(1, 6)]
    came = bench.run(Schedule(items={"i": [(2, item) for item in items]}, stalls={}))
    assert came == {"o": [
        {"phase": phase, "item": item | {"parts": item["parts"][phase:] + item["parts"][:phase]}}
        for item in items for phase in range(3)]}


@pytest.mark.parametrize("turned", ["absent", "number", "short"])
def test_a_field_that_turns_has_an_element_for_each_phase(turned):
    shape = StructLayout({"number": 8, "short": ArrayLayout(8, 2)})
    with pytest.raises(ValueError, match=f"^Turned must be the name of an array of 3 elements, not '{turned}'$"):
        TimeMultiplexer(shape, count=3, turned=turned)
    with pytest.raises(ValueError, match=f"^Turned must be the name of an array of 3 elements, not '{turned}'$"):
        TimeMultiplexer(8, count=3, turned=turned)


def test_the_name_of_a_field_that_turns_is_a_string():
    with pytest.raises(TypeError, match=r"^Turned must be a str, not 0$"):
        TimeMultiplexer(SHAPE, count=3, turned=0)
