import pytest
from hypothesis import given
from hypothesis import strategies as st

from golden.engine.config import PRESETS
from golden.engine.memory_map import REGIONS
from hw.memsys.load.image_layout import RegionNumber
from hw.memsys.load.record_extent import RecordExtent
from hw.memsys.port.memory_formats import LENGTH_BITS
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench, payloads, schedules
from tb.lib.timing import documented_latency

# Of these less than all records are read.
PARTIAL = (RegionNumber.CLUSTERS, RegionNumber.SUBSHELLS, RegionNumber.RESIDENTS)
CONFIG = PRESETS["tiny"]
DUT = RecordExtent(config=CONFIG)
BENCH = ScheduleBench(DUT, ["i"], ["o"])
ADDRESS = 1 << CONFIG.memory.address_bits
ITEM = payloads(DUT.i.payload.shape())


def expected(item):
    """Bytes and words as numpy has them of the region's records."""
    size = REGIONS[item["region"]].dtype.itemsize
    return {"address": (item["image"] + item["offset"] + size * item["first"]) % ADDRESS,
            "length": -(-size // 8) * item["records"] - 1, "narrow": int(size < 8)}


def most(region):
    """Records of the longest extent."""
    return min((1 << 32) - 1, (1 << LENGTH_BITS) // -(-REGIONS[region.value].dtype.itemsize // 8))


@SETTINGS
@given(schedules({"i": st.builds(
    lambda item, region, share: item | {
        "region": region.value, "records": 1 + (most(region) - 1) * share // 100,
        "first": item["first"] if region in PARTIAL else 0},
    ITEM, st.sampled_from(list(RegionNumber)), st.integers(0, 100))}, ["o"]))
def test_extents_are_the_bytes_of_the_records(schedule):
    assert BENCH.run(schedule)["o"] == [expected(item) for item in schedule.values("i")]


@pytest.mark.parametrize("region", RegionNumber)
def test_one_record_and_all_that_can_be(region):
    item = {"image": 64, "offset": 4096, "region": region.value, "first": 0}
    for records in (1, 2, most(region)):
        found = BENCH.run(single(item | {"records": records}))["o"]
        assert found == [expected(item | {"records": records})]


def single(item):
    return Schedule(items={"i": [(0, item)]}, stalls={"o": []})


def test_latency():
    BENCH.run(single({"image": 0, "offset": 0, "region": 0, "first": 0, "records": 1}))
    assert BENCH.cycles["o"][0] - BENCH.cycles["i"][0] == DUT.latency == documented_latency(RecordExtent, CONFIG)
