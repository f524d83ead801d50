from hypothesis import given
from hypothesis import strategies as st

from golden.engine.config import PRESETS
from hw.memsys.bus.patch_extents import PatchExtents
from hw.memsys.load.image_layout import PATCH_WORDS
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"]
MOST = 1 << PatchExtents.index_bits
DUT = PatchExtents(config=CONFIG)
BENCH = ScheduleBench(DUT, ["i_id", "i"], ["o"])
# Of a drawn schedule.
SOME = 16
IDS = st.integers(0, (1 << 32) - 1)


def schedule_of(ids, base, count, stalls=(), gap=0):
    given_ids = [(0, {"index": index, "id": number}) for index, number in enumerate(ids)]
    return Schedule(items={"i_id": given_ids, "i": [(len(ids) + gap, {"base": base, "count": count})]},
                    stalls={"o": list(stalls)})


def expected(ids, base, count):
    addresses = 1 << CONFIG.memory.address_bits
    return [{"address": (base + 64 * number) % addresses, "length": PATCH_WORDS - 1, "narrow": 0}
            for number in ids[:count]]


@SETTINGS
@given(st.lists(IDS, min_size=1, max_size=SOME), st.integers(0, (1 << CONFIG.memory.address_bits) - 1),
       st.lists(st.integers(0, 3), max_size=SOME), st.data())
def test_extents_are_the_records_of_the_ids_in_order(ids, base, stalls, data):
    count = data.draw(st.integers(1, len(ids)))
    assert BENCH.run(schedule_of(ids, base, count, stalls))["o"] == expected(ids, base, count)


def test_all_ids_that_there_can_be():
    ids = [7 * k + 1 for k in range(MOST)]
    assert BENCH.run(schedule_of(ids, 4096, MOST))["o"] == expected(ids, 4096, MOST)


def test_ids_of_before_are_replaced_and_an_extent_leaves_per_cycle():
    ids = [3, 1, 2]
    first = schedule_of(ids, 64, 3)
    again = Schedule(items={"i_id": first.items["i_id"] + [(20, {"index": 1, "id": 9})],
                            "i": first.items["i"] + [(20, {"base": 64, "count": 2})]}, stalls={"o": []})
    assert BENCH.run(again)["o"] == expected(ids, 64, 3) + expected([3, 9], 64, 2)
    given_at, taken = BENCH.cycles["i"], BENCH.cycles["o"]
    assert taken[0] - given_at[0] == DUT.latency == documented_latency(PatchExtents, CONFIG)
    assert taken[1] - taken[0] == taken[2] - taken[1] == 1


@SETTINGS
@given(st.lists(st.integers(0, 3), max_size=6), st.integers(1, 3))
def test_the_next_ones_wait_until_the_last_extent_has_been_taken(stalls, count):
    ids = [5, 6, 7]
    first = schedule_of(ids, 64, count, stalls)
    again = Schedule(items={**first.items, "i": [*first.items["i"], (0, {"base": 128, "count": 3})]},
                     stalls=first.stalls)
    assert BENCH.run(again)["o"] == expected(ids, 64, count) + expected(ids, 128, 3)
    assert BENCH.cycles["i"][1] == BENCH.cycles["o"][count - 1] + 1
