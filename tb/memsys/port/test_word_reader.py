import pytest
from hypothesis import given
from hypothesis import strategies as st

from golden.engine.config import PRESETS
from hw.memsys.port.word_reader import WordReader
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench
from tb.lib.timing import documented_latency

LENGTH_BITS = 2
MOST = 1 << LENGTH_BITS
CONFIGS = {bits: PRESETS["tiny"].replace({"memory.data_bits": bits, "memory.length_bits": LENGTH_BITS})
           for bits in (64, 128, 256, 512)}
BENCHES = {bits: ScheduleBench(WordReader(config=config), ["i", "i_reply"], ["o", "o_request"])
           for bits, config in CONFIGS.items()}
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


def requests(extent, beat_bytes):
    """First bytes and lengths: all beats of an extent, as many as there may be in each request."""
    size = 4 if extent["narrow"] else 8
    address = extent["address"]
    first, last = address // beat_bytes, (address + size * extent["length"]) // beat_bytes
    return [{"address": beat_bytes * beat, "length": min(MOST, last - beat + 1) - 1, "tag": 0}
            for beat in range(first, last + 1, MOST)]


def replies(requested, errors, beat_bytes):
    """Beats of the requests in order; of some, errors."""
    beats = [(request["address"] + beat_bytes * k, k == request["length"]) for request in requested
             for k in range(request["length"] + 1)]
    return [{"data": int.from_bytes(bytes(byte_at(address + j) for j in range(beat_bytes)), "little"), "tag": 0,
             "last": int(last), "error": int(number in errors)} for number, (address, last) in enumerate(beats)]


@pytest.mark.parametrize("bits", CONFIGS)
@SETTINGS
@given(extents=st.lists(st.tuples(st.integers(0, 3), EXTENT), min_size=1, max_size=5), gaps=STALLS, slow=STALLS,
       stalls=STALLS, errors=st.sets(st.integers(0, 12), max_size=2))
def test_words_are_the_bytes_of_memory(bits, extents, gaps, slow, stalls, errors):
    size = bits // 8
    requested = [request for _, extent in extents for request in requests(extent, size)]
    beats, gap = replies(requested, errors, size), iter(gaps)
    schedule = Schedule(items={"i": extents, "i_reply": [(next(gap, 0), beat) for beat in beats]},
                        stalls={"o": stalls, "o_request": slow})
    found = BENCHES[bits].run(schedule)
    assert found["o_request"] == requested
    expected = [(word, int(index == extent["length"])) for _, extent in extents
                for index, word in enumerate(words(extent))]
    assert [word["last"] for word in found["o"]] == [last for _, last in expected]
    assert [word["data"] % (1 << 32 if narrow else 1 << 64) for word, narrow in zip(found["o"], [
        extent["narrow"] for _, extent in extents for _ in words(extent)], strict=True)] == [
            word for word, _ in expected]
    assert sum(word["error"] for word in found["o"]) >= bool(errors & set(range(len(beats))))
    assert errors or not any(word["error"] for word in found["o"])


@pytest.mark.parametrize("bits", CONFIGS)
def test_latency(bits):
    extent, bench, latency = {"address": 8, "length": 1, "narrow": 0}, BENCHES[bits], WordReader.latency
    beats = replies(requests(extent, bits // 8), (), bits // 8)
    bench.run(Schedule(items={"i": [(0, extent)], "i_reply": [(9, beat) for beat in beats]}, stalls={}))
    cycles = bench.cycles
    assert cycles["o_request"][0] - cycles["i"][0] <= latency == documented_latency(WordReader, CONFIGS[bits])
    # A beat is accepted with the last of its words.
    assert cycles["o"][0] == cycles["i_reply"][0] - (min(bits // 64 - 1, 2) - 1 if bits > 64 else 0)
