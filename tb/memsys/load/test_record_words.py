from hypothesis import given
from hypothesis import strategies as st

from golden.engine.config import PRESETS
from hw.memsys.load.image_layout import PATCH_WORDS, RECORD_WORDS, RegionNumber
from hw.memsys.load.record_words import RecordWords
from hw.memsys.port.fault import Fault
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench, payloads, schedules
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"]
DUT = RecordWords(config=CONFIG)
BENCH = ScheduleBench(DUT, ["i"], ["o"])
# Records of one word, of several, and of a patch, which has padding.
REGIONS = [RegionNumber.PATCHES, RegionNumber.RESIDENTS, RegionNumber.COLUMNS, RegionNumber.SHELLS]


def run(schedule, region, *, limit=(1 << 32) - 1, start=0, record=0):
    return BENCH.run(schedule, region=region, limit=limit, start=start, record=record)["o"]


def words(*data):
    """Words that come when the region is known."""
    return Schedule(items={"i": [(3, {"data": one, "last": 0, "error": 0}) for one in data]}, stalls={"o": []})


@SETTINGS
@given(schedules({"i": payloads(DUT.i.payload.shape())}, ["o"], most=8), st.sampled_from(REGIONS))
def test_words_are_numbered_in_their_records(schedule, region):
    size = PATCH_WORDS if region is RegionNumber.PATCHES else RECORD_WORDS[region.value]
    items = [(idle + 2 * (number == 0), word) for number, (idle, word) in enumerate(schedule.items["i"])]
    found = run(Schedule(items={"i": items}, stalls=schedule.stalls), region)
    assert [one["item"] for one in found] == [
        {"region": region.value, "record": number // size, "word": number % size, "data": word["data"]}
        for number, (_, word) in enumerate(items)]
    assert [one["last"] for one in found] == [word["last"] for _, word in items]
    # A word that was not read has no other fault.
    assert [one["fault"] == Fault.READ_REPLY.value for one in found] == [word["error"] == 1 for _, word in items]


def test_faults_of_the_check_are_reported():
    found = run(words(5, 6), RegionNumber.RESIDENTS, limit=6)
    assert [one["fault"] for one in found] == [Fault.NONE.value, Fault.POINTER.value]


def test_start_names_the_first_record():
    """While ``start`` is 1 the number is that of ``record``."""
    found, = run(words(0), RegionNumber.COLUMNS, start=1, record=41)
    assert found["item"]["record"] == 41


def test_latency():
    run(words(0), RegionNumber.COLUMNS)
    assert BENCH.cycles["o"][0] - BENCH.cycles["i"][0] == DUT.latency == documented_latency(RecordWords, CONFIG)
