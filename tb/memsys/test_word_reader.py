from hypothesis import given
from hypothesis import strategies as st

from golden.config import PRESETS
from hw.memsys.word_reader import WordReader
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"].replace({"memory.data_bits": 128, "memory.length_bits": 2})
BEAT = CONFIG.memory.beat_bytes
MOST = 1 << CONFIG.memory.length_bits
DUT = WordReader(config=CONFIG)
BENCH = ScheduleBench(DUT, ["i", "i_reply"], ["o", "o_request"])
EXTENT = st.builds(lambda word, count, narrow: {"address": (4 if narrow else 8) * word, "length": count - 1,
                                                "narrow": int(narrow)},
                   st.integers(0, 4000), st.integers(1, 22), st.booleans())
STALLS = st.lists(st.integers(0, 4), max_size=30)


def byte_at(address):
    return (address * 37 ^ address >> 3) & 0xFF


def words(extent):
    """Bytes of memory, word by word."""
    size = 4 if extent["narrow"] else 8
    first = extent["address"]
    return [int.from_bytes(bytes(byte_at(first + size * k + j) for j in range(size)), "little")
            for k in range(extent["length"] + 1)]


def requests(extent):
    """First bytes and lengths: all beats of an extent, as many as there may be in each request."""
    size = 4 if extent["narrow"] else 8
    first, last = extent["address"] // BEAT, (extent["address"] + size * extent["length"]) // BEAT
    return [{"address": BEAT * beat, "length": min(MOST, last - beat + 1) - 1, "tag": 0}
            for beat in range(first, last + 1, MOST)]


def replies(requested, errors):
    """Beats of the requests in order; of some, errors."""
    beats = [(request["address"] + BEAT * k, k == request["length"]) for request in requested
             for k in range(request["length"] + 1)]
    return [{"data": int.from_bytes(bytes(byte_at(address + j) for j in range(BEAT)), "little"), "tag": 0,
             "last": int(last), "error": int(number in errors)} for number, (address, last) in enumerate(beats)]


@SETTINGS
@given(st.lists(st.tuples(st.integers(0, 3), EXTENT), min_size=1, max_size=5), STALLS, STALLS, STALLS,
       st.sets(st.integers(0, 12), max_size=2))
def test_words_are_the_bytes_of_memory(extents, gaps, slow, stalls, errors):
    requested = [request for _, extent in extents for request in requests(extent)]
    beats, gap = replies(requested, errors), iter(gaps)
    schedule = Schedule(items={"i": extents, "i_reply": [(next(gap, 0), beat) for beat in beats]},
                        stalls={"o": stalls, "o_request": slow})
    found = BENCH.run(schedule)
    assert found["o_request"] == requested
    expected = [(word, int(index == extent["length"])) for _, extent in extents
                for index, word in enumerate(words(extent))]
    assert [word["last"] for word in found["o"]] == [last for _, last in expected]
    assert [word["data"] % (1 << 32 if narrow else 1 << 64) for word, narrow in zip(found["o"], [
        extent["narrow"] for _, extent in extents for _ in words(extent)], strict=True)] == [
            word for word, _ in expected]
    assert sum(word["error"] for word in found["o"]) >= bool(errors & set(range(len(beats))))
    assert errors or not any(word["error"] for word in found["o"])


def test_latency():
    extent = {"address": 8, "length": 1, "narrow": 0}
    beats = replies(requests(extent), ())
    BENCH.run(Schedule(items={"i": [(0, extent)], "i_reply": [(9, beat) for beat in beats]}, stalls={}))
    assert BENCH.cycles["o_request"][0] - BENCH.cycles["i"][0] <= DUT.latency == documented_latency(WordReader, CONFIG)
    assert BENCH.cycles["o"][0] == BENCH.cycles["i_reply"][0]
