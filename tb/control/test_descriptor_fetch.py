import random

import pytest

from golden.engine.config import PRESETS
from golden.engine.jobs.descriptor import DESCRIPTOR
from hw.control.descriptor_fetch import DESCRIPTORS, DescriptorFetch
from hw.control.job_formats import DESCRIPTOR_WORDS, NEAR_INDEX
from tb.control.job_descriptors import WIDTHS, byte_at, descriptor, near_words, words_of
from tb.lib.responder import Responder
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency
from tb.memsys.results.extent import saturated

BASE = PRESETS["tiny"].replace({"ctu.near_cell_bits": 9})
RING = 0x7C0
SIZE = DESCRIPTOR.dtype.itemsize
# The word with the number of near cells, after which they may be requested.
COUNT_WORD = DESCRIPTOR.dtype.fields["near_count"][1] // 8


class Fetch:
    """A fetch at a memory with some descriptors.

    Parameters
    ----------
    width
        Bits of a beat.
    changes
        Of the configuration.
    """

    def __init__(self, width=64, **changes):
        self.config = BASE.replace({"memory.data_bits": width, **changes})
        self.dut = DescriptorFetch(config=self.config)
        self.bench = ScheduleBench(self.dut, ["i_reply"], ["o", "o_request"], idle_limit=60, watchdog=30_000)

    def run(self, ones, *, taken=0, ring_bits=3, stalls=(), errors=(), after=5, doorbell=None, enable=1):
        """What comes out, and the requests."""
        self.memory = {}
        self.entries = [RING + SIZE * ((taken + number) % (1 << ring_bits)) for number in range(len(ones))]
        for entry, one in zip(self.entries, ones, strict=True):
            self.memory |= dict(enumerate(one.tobytes(), start=entry))
        self.errors, size = set(errors), self.config.memory.beat_bytes

        def answer(request):
            first, last = request["address"], request["length"]
            assert first % size == 0
            return [{"data": int.from_bytes(bytes(self.byte(first + size * k + j) for j in range(size)), "little"),
                     "tag": 0, "last": int(k == last), "error": int(self.is_error(first + size * k))}
                    for k in range(last + 1)]

        return self.bench.run(
            Schedule(items={}, stalls={"o": list(stalls)}), Responder("o_request", "i_reply", answer, after),
            ring=RING, ring_bits=ring_bits, taken=taken, enable=enable,
            doorbell=(taken + len(ones)) % (1 << 32) if doorbell is None else doorbell)

    def byte(self, address):
        return self.memory.get(address, byte_at(address))

    def is_error(self, address):
        """Whether the beat of an address has an error."""
        size = self.config.memory.beat_bytes
        return any(address // size == error // size for error in self.errors)

    def expected(self, ones):
        """The words of descriptors and near cells; near cells of which not all is known are not read."""
        found = []
        for entry, one in zip(self.entries, ones, strict=True):
            errors = [int(self.is_error(entry + 8 * index)) for index in range(DESCRIPTOR_WORDS)]
            near = 0 if any(errors[:COUNT_WORD + 1]) else near_words(one, self.config)
            found += [{"index": index, "data": word, "last": int(not near and index == DESCRIPTOR_WORDS - 1),
                       "error": error} for index, (word, error) in enumerate(zip(words_of(one), errors, strict=True))]
            for k in range(near):
                address = int(one["near_cells"]) + 8 * k
                found.append({"index": NEAR_INDEX, "last": int(k == near - 1), "error": int(self.is_error(address)),
                              "data": int.from_bytes(bytes(self.byte(address + j) for j in range(8)), "little")})
        return found


@pytest.fixture(scope="module", params=[64, pytest.param(512, marks=pytest.mark.sim)])
def width(request):
    return request.param


@pytest.fixture(scope="module")
def fetch(width):
    return Fetch(width)


@pytest.mark.parametrize("width", WIDTHS, scope="module")
def test_beats_of_all_widths(width):
    fetch, draw = Fetch(width), random.Random(width)
    ones = [descriptor(fetch.config, draw, near_count=count) for count in (3, 40, 0, 1)]
    assert fetch.run(ones, stalls=[0, 3, 0, 1])["o"] == fetch.expected(ones)


@pytest.mark.parametrize(("taken", "ring_bits"), [(0, 3), (5, 2), ((1 << 32) - 3, 3), (7, 0), (3, 1), (1 << 31, 4)])
def test_descriptors_and_their_near_cells(fetch, taken, ring_bits):
    """Rings of 1, 2 and 2^n entries; numbers that wrap."""
    draw = random.Random(taken)
    ones = [descriptor(fetch.config, draw) for _ in range(1 << min(ring_bits, 3))]
    for stalls in (), [draw.choice((0, 0, 1, 4)) for _ in range(200)]:
        found = fetch.run(ones, taken=taken, ring_bits=ring_bits, stalls=stalls)
        assert found["o"] == fetch.expected(ones)


@pytest.mark.parametrize("count", [0, 1, 2, 33, 257, 511, 512, 513])
def test_numbers_of_near_cells(fetch, count):
    """None, odd ones, more than are requested at once or held, the most that a cluster stores, and one more."""
    draw = random.Random(count)
    ones = [descriptor(fetch.config, draw, near_count=count) for _ in range(2)]
    found = fetch.run(ones, stalls=[40] if count > 300 else ())
    assert found["o"] == fetch.expected(ones)


@pytest.mark.parametrize(("cells", "rays"), [(0, 1), (5, 3), (6, 32), (5, 33), (513, 3)])
def test_listed_rays_follow_near_cells(cells, rays):
    """The most that a cluster stores, and one more; one word more than near cells alone may need."""
    fetch, draw = Fetch(64, **{"icu.shadow_bits": 5}), random.Random(rays)
    ones = [descriptor(fetch.config, draw, near_count=cells, ray_count=rays), descriptor(fetch.config, draw)]
    assert near_words(ones[0], fetch.config) == (0 if rays > 32 or cells > 512 else -(-cells // 2) + rays)
    assert fetch.run(ones, stalls=[30])["o"] == fetch.expected(ones)


@pytest.mark.parametrize("fields", [
    {"kind": 1}, {"kind": 9}, {"near_cells": 4}, {"near_cells": 1 << 40}, {"near_cells": (1 << 64) - 8},
    {"near_count": (1 << 32) - 1}, {"near_count": 1 << 31}])
def test_near_cells_that_are_not_read(fetch, fields):
    draw = random.Random(3)
    ones = [descriptor(fetch.config, draw, **{"near_count": 5, **fields}), descriptor(fetch.config, draw)]
    assert near_words(ones[0], fetch.config) == 0
    assert fetch.run(ones)["o"] == fetch.expected(ones)


@pytest.mark.parametrize("bits", [16, 40])
def test_what_lies_past_the_end_of_memory_stays_there(bits):
    """A ring and near cells that reach beyond it, also around the whole of a small memory."""
    fetch, top, beyond = Fetch(64, **{"memory.address_bits": bits}), 1 << bits, random.Random(bits).randrange(2, 9999)
    near = descriptor(fetch.config, random.Random(3), near_count=64, near_cells=top - 128)
    found = fetch.run([near])
    assert [request["address"] for request in found["o_request"]][1:] == [top - 128, top]
    for taken in 1, beyond:
        found = fetch.bench.run(Schedule(items={}), ring=top - SIZE, ring_bits=31, taken=taken, doorbell=taken + 1,
                                enable=1)
        assert [request["address"] for request in found["o_request"]] == [saturated(top + SIZE * (taken - 1), bits)]


def test_replies_never_wait(fetch):
    """Nobody takes a word for long, then for a while none of near cells: all requests are answered in the meantime, and
    only so many are made.
    """
    draw = random.Random(8)
    ones = [descriptor(fetch.config, draw, near_count=300) for _ in range(8)]
    found = fetch.run(ones, stalls=[2000, *[0] * (DESCRIPTOR_WORDS + 4), 200])
    cycles = fetch.bench.cycles
    early = [cycle for cycle in cycles["o_request"] if cycle < cycles["o"][0]]
    answered = [cycle for cycle in cycles["i_reply"] if cycle < cycles["o"][0]]
    beats = sum(request["length"] + 1 for request, _ in zip(found["o_request"], early, strict=False))
    assert len(answered) == beats
    assert max(answered) < 1500
    requested = [request["address"] for request, _ in zip(found["o_request"], early, strict=False)]
    assert sum(RING <= address < RING + 8 * SIZE for address in requested) == DESCRIPTORS
    assert found["o"] == fetch.expected(ones)


def test_nothing_is_read_beyond_the_doorbell(fetch):
    assert fetch.run([], taken=9) == {"o": [], "o_request": []}


def test_no_descriptor_is_requested_without_enable(fetch):
    """After the first request until the words of the first descriptor have come; all others follow then."""
    draw = random.Random(11)
    ones = [descriptor(fetch.config, draw, near_count=0) for _ in range(6)]
    found = fetch.run(ones, stalls=[150], enable=lambda cycles: int(
        not cycles["o_request"] or len(cycles["o"]) >= DESCRIPTOR_WORDS))
    enabled = fetch.bench.cycles["o"][DESCRIPTOR_WORDS - 1]
    early = {(request["address"] - RING) // SIZE
             for request, cycle in zip(found["o_request"], fetch.bench.cycles["o_request"], strict=True)
             if cycle < enabled}
    # The enable is known a cycle late.
    assert early <= {0, 1}
    assert found["o"] == fetch.expected(ones)


@pytest.mark.parametrize("word", [0, 3, 6, COUNT_WORD - 1, COUNT_WORD, COUNT_WORD + 1, 23])
def test_a_descriptor_that_cannot_be_read(fetch, word):
    """The words of its beat have the error, and the next descriptor follows."""
    draw = random.Random(word)
    ones = [descriptor(fetch.config, draw, near_count=4) for _ in range(3)]
    assert fetch.run(ones, errors=[RING + SIZE + 8 * word])["o"] == fetch.expected(ones)


@pytest.mark.parametrize(("cells", "rays", "word"), [
    (1, 0, 0), (6, 0, 0), (6, 0, 1), (6, 0, 2), (40, 0, 9), (1, 30, 1), (5, 30, 3), (5, 30, 32)])
def test_near_cells_and_listed_rays_that_cannot_be_read(width, cells, rays, word):
    """The words of their beat have the error."""
    fetch, draw = Fetch(width, **{"icu.shadow_bits": 5}), random.Random(word)
    ones = [descriptor(fetch.config, draw, near_count=cells, near_cells=0x4000 * (1 + k), ray_count=rays)
            for k in range(2)]
    found = fetch.run(ones, errors=[0x4000 + 8 * word])["o"]
    assert any(one["error"] for one in found)
    assert found == fetch.expected(ones)


def test_rate(fetch):
    """A word per cycle once the first has come; from a descriptor to the next without a gap, near cells included."""
    draw = random.Random(4)
    ones = [descriptor(fetch.config, draw, near_count=14) for _ in range(8)]
    fetch.run(ones, after=8, stalls=[150])
    cycles, words = fetch.bench.cycles["o"], DESCRIPTOR_WORDS + 7
    # Those that were read ahead.
    assert cycles[DESCRIPTORS * words - 1] - cycles[0] == DESCRIPTORS * words - 1
    # The others come as fast as memory answers: one descriptor in the time of both round trips at most.
    assert cycles[-1] - cycles[0] < 8 * words + 4 * 60


def test_latency():
    fetch = Fetch()
    fetch.run([descriptor(fetch.config, random.Random(1))])
    cycles = fetch.bench.cycles
    assert cycles["o"][0] - cycles["i_reply"][0] == documented_latency(DescriptorFetch, BASE) == DescriptorFetch.latency


def test_short_requests():
    fetch, draw = Fetch(64, **{"memory.length_bits": 1, "memory.outstanding": 1}), random.Random(6)
    ones = [descriptor(fetch.config, draw, near_count=9) for _ in range(5)]
    assert fetch.run(ones)["o"] == fetch.expected(ones)
