"""Sources that share a port: whose request, data and answer. `tb.formal.memsys.test_write_merge` has proofs."""

from collections import deque
from itertools import pairwise
from random import Random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from golden.engine.config import PRESETS
from hw.memsys.port.write_merge import WriteMerge
from tb.lib.bench import Bench, Vectors
from tb.lib.responder import Responder
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench
from tb.lib.timing import documented_latency
from tb.memsys.write_memory import WriteMemory

COUNT = 3
CONFIG = PRESETS["tiny"]


def requests_of(random, source, count=10, longest=6):
    """Requests of a source and their beats; the data tell whose they are."""
    requested, beats = [], []
    for number in range(count):
        length = random.choice((0, 0, 1, random.randrange(longest)))
        requested.append({"address": 4096 * (COUNT * number + source), "length": length})
        beats += [{"data": source << 60 | number << 32 | beat, "strobe": random.randrange(256)}
                  for beat in range(length + 1)]
    return requested, beats


class TestWriteMerge(Bench):
    """Requests of a source stay in its order; data in the order of the requests, whoever sends when."""

    variants, splits, idle_limit = [{"memory.data_bits": 64}], False, 30

    def make(self, config):
        return WriteMerge(config=config, count=COUNT)

    def vectors(self, config):
        return self.drawn(config, 1)

    def drawn(self, config, seed):
        given = [requests_of(Random(10 * seed + k), k) for k in range(COUNT)]
        return Vectors(inputs={f"i_request__{k}": requested for k, (requested, _) in enumerate(given)}
                       | {f"i_data__{k}": beats for k, (_, beats) in enumerate(given)}
                       | {"i_written": [{"tag": number % COUNT, "error": number % 2} for number in range(20)]},
                       expected={}, about=given)

    def is_over(self, given, came):
        return len(came["o_data"]) == sum(len(beats) for _, beats in given.about) and sum(
            len(came[f"o_written__{k}"]) for k in range(COUNT)) == len(given.inputs["i_written"])

    def check(self, given, came):
        requested, data = self.values("o_request", came), deque(self.values("o_data", came))
        beats = [deque(beats) for _, beats in given.about]
        for k in range(COUNT):
            assert [{**item, "tag": k} for item in given.about[k][0]] == [one for one in requested if one["tag"] == k]
            assert [one["error"] for one in self.values(f"o_written__{k}", came)] == [
                one["error"] for one in given.inputs["i_written"] if one["tag"] == k]
        for request in requested:
            for _ in range(request["length"] + 1):
                assert data.popleft() == beats[request["tag"]].popleft()
        assert not data

    def check_times(self, given, cycles, latency):
        assert cycles["o_request"][0] - cycles["i_request__0"][0] == latency - 1
        assert cycles["o_written__0"][0] - cycles["i_written"][0] == 1


BENCH = ScheduleBench(WriteMerge(config=CONFIG, count=COUNT), idle_limit=60)


def run(sources, *, stalls=None, memory=None, delay=(0, 9)):
    """What comes out, the requests and beats being without gaps."""
    items = {f"i_request__{k}": [(0, item) for item in requested] for k, (requested, _) in enumerate(sources)}
    items |= {f"i_data__{k}": [(0, item) for item in beats] for k, (_, beats) in enumerate(sources)}
    memory = memory or WriteMemory(64)
    return BENCH.run(Schedule(items=items, stalls=stalls or {}),
                     Responder("o_request", "i_written", memory.request),
                     Responder("o_data", "i_written", memory.data, after=delay))


@SETTINGS
@given(st.lists(st.integers(0, 8), min_size=COUNT, max_size=COUNT), st.integers(0, 99),
       st.sets(st.integers(0, 15)), st.fixed_dictionaries(dict.fromkeys(
           ("o_data", "o_written__1"), st.lists(st.sampled_from((0, 0, 1, 6)), max_size=20))))
def test_each_source_gets_its_answers(counts, seed, fails, stalls):
    """What is written is each source's own; errors go to the source of the request."""
    sources = [requests_of(Random(seed + k), k, count) for k, count in enumerate(counts)]
    memory = WriteMemory(64, fails=fails)
    came = run(sources, stalls=stalls, memory=memory)
    for k, count in enumerate(counts):
        errors = [number in fails for number, request in enumerate(came["o_request"]) if request["tag"] == k]
        assert [bool(one["error"]) for one in came[f"o_written__{k}"]] == errors
        assert len(errors) == count


def test_one_beat_per_cycle():
    """Requests of two beats of one source, of all of them, and of one beat of all; grants in turn."""
    for counts, length in (((8, 0, 0), 1), ((8, 8, 8), 1), ((8, 8, 8), 0), ((2, 2, 2), 15)):
        sources = [([{"address": 4096 * k, "length": length}] * count, [{"data": k, "strobe": 255}] * count * (
            length + 1)) for k, count in enumerate(counts)]
        came, cycles = run(sources), BENCH.cycles
        assert {b - a for a, b in pairwise(cycles["o_data"])} == {1}
        assert [one["tag"] for one in came["o_request"]] == [
            k for turn in range(max(counts)) for k in range(COUNT) if turn < counts[k]]


def test_latency():
    """The first request at the port after its offer, its first beat after it; an answer."""
    run([requests_of(Random(1), 0, 1), ([], []), ([], [])], delay=5)
    cycles = BENCH.cycles
    assert cycles["o_request"][0] - 1 == documented_latency(WriteMerge, CONFIG)
    assert cycles["o_data"][0] - cycles["i_data__0"][0] == 1
    assert cycles["i_data__0"][0] - cycles["o_request"][0] == 1
    assert cycles["o_written__0"][0] - cycles["i_written"][0] == 1


@pytest.mark.parametrize(("count", "error"), [(0, ValueError), ("2", TypeError)])
def test_init_wrong_count(count, error):
    with pytest.raises(error, match=f"^Count must be at least 1, not {count!r}$"):
        WriteMerge(config=CONFIG, count=count)
