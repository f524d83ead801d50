import random
from collections import Counter, deque
from itertools import pairwise

import numpy as np
import pytest
from amaranth.hdl import Value
from amaranth.sim import Simulator

from golden.engine.config import PRESETS
from golden.engine.jobs.completion import COMPLETION, NO_CLUSTER, has_arrived, lap, parse_completions
from hw.control.completion_writer import RECORDS, CompletionWriter
from hw.control.job_formats import COMPLETION_WORDS
from hw.lib.payload import pack, unpack
from hw.registers.error_code import ErrorCode
from tb.control.job_descriptors import WIDTHS
from tb.lib.timing import documented_latency

NODES = 3
BASE = PRESETS["tiny"].replace({"noc.columns": NODES, "noc.rows": 1})
RING = 0x5C0
SIZE = COMPLETION.dtype.itemsize
# Cycles of a reset: one, while memory is idle, and more.
RESETS = 1, 4


class Writer:
    """A completion writer between clusters, the control and a memory.

    Members
    -------
    records
        By number what was collected, as bytes without the lap.
    memory
        Bytes.
    beats, collected, requests
        Cycles of beats, of ends of records, of requests.
    """

    def __init__(self, width=64, nodes=NODES, **changes):
        self.config = BASE.replace({"noc.columns": nodes, "memory.data_bits": width, **changes})
        self.nodes, self._dut, self._has_run = nodes, CompletionWriter(config=self.config), False
        self._simulator = Simulator(self._dut)
        self._simulator.add_clock(1e-8)

    def run(self, counts, *, own=0, seed=0, ring_bits=3, gaps=0.0, slow=0.0, late=None, after=(3, 9), fails=(),
            stops=(), aborts=False, cycles=3000):
        """Write some records of each cluster, and ``own`` others.

        Parameters
        ----------
        gaps, slow
            How often a source has no word, and memory accepts no request, or no beat.
        late
            How often memory accepts no request, if not ``slow``.
        after
            Cycles from the last beat to the answer.
        fails
            Numbers of requests that memory refuses; a reset and a retry follow.
        stops
            First cycles of resets.
        aborts
            After a reset the clusters have no more records: others take the place of those that they had.
        """
        self._given = (counts, own, seed, ring_bits, gaps, slow, slow if late is None else late, after, set(fails),
                       set(stops), aborts, cycles)
        self.records, self.memory, self.beats, self.collected, self.requests = [], {}, [], [], []
        self.failures, self.completed, self.sources = [], 0, []
        if self._has_run:
            self._simulator.reset()
        else:
            self._simulator.add_testbench(self._drive)
        self._has_run = True
        self._simulator.run()
        return self

    async def _drive(self, ctx):
        dut = self._dut
        counts, own, seed, ring_bits, gaps, slow, late, after, fails, stops, aborts, cycles = self._given
        draw, left, size = random.Random(seed), list(counts), self.config.memory.beat_bytes
        words, sent, tags = [deque() for _ in counts], [[] for _ in counts], [0] * self.nodes
        offers, record, requests, answers = [False] * self.nodes, None, deque(), deque()
        stopping = idle = number = retry = 0
        ctx.set(dut.completions, RING)
        ctx.set(dut.ring_bits, ring_bits)
        layout = dut.i_record.payload.shape()
        ports = [Value.cast(one) for one in (
            dut.o_request.valid, dut.o_request.payload, dut.o_data.valid, dut.o_data.payload, dut.o_collected.valid,
            dut.o_collected.payload, dut.i_record.ready, dut.completed, dut.empty, dut.failed, dut.address,
            *(one.ready for one in dut.i))]
        for cycle in range(cycles):
            stopping = draw.choice(RESETS) if cycle in stops else max(0, stopping - 1)
            ctx.set(dut.stops, int(stopping > 0))
            retry = max(0, retry - 1)
            ctx.set(dut.retry, int(retry == 1))
            for k in range(self.nodes):
                if not words[k] and left[k]:
                    words[k] = deque(draw.getrandbits(64) for _ in range(COMPLETION_WORDS))
                    tags[k], sent[k] = draw.getrandbits(32), []
                offers[k] = bool(words[k]) and (offers[k] or draw.random() >= gaps)
                ctx.set(dut.i[k].valid, int(offers[k]))
                ctx.set(dut.i[k].payload, words[k][0] if offers[k] else 0)
            if record is None and own:
                record = {"tag": draw.getrandbits(32), "code": draw.choice(list(ErrorCode)).value, "begin":
                          draw.getrandbits(32), "end": draw.getrandbits(32), "cluster": NO_CLUSTER,
                          "number": draw.getrandbits(40)}
            ctx.set(dut.i_record.valid, int(record is not None))
            ctx.set(Value.cast(dut.i_record.payload), pack(layout, record))
            ready, data_ready = draw.random() >= late, draw.random() >= slow
            ctx.set(dut.o_request.ready, int(ready))
            ctx.set(dut.o_data.ready, int(data_ready))
            due = bool(answers) and answers[0][0] <= cycle
            ctx.set(dut.i_written.valid, int(due))
            ctx.set(dut.i_written.payload.error, int(due and answers[0][1]))
            ctx.set(dut.tag, tags[ctx.get(dut.source)])
            (_, _, request, place, data, beat, collected, source, took, self.completed, empty, failed, oldest,
             *readies) = await ctx.tick().sample(*ports)
            if due:
                answers.popleft()
            if retry:
                assert failed, "a failure stays until the retry"
                assert not request, "nothing is requested between a failure and the retry"
            if failed and (not self.failures or self.failures[-1][0] + 30 < cycle):
                self.failures.append((cycle, oldest))
                stops, retry = stops | {cycle + 3}, 14
            if stopping:
                assert not any((request, data, collected, took, *readies))
                requests.clear()
                answers.clear()
                # The clusters are reset: their sections are lost.
                words, offers = [deque() for _ in counts], [False] * self.nodes
                if aborts:
                    own, left = own + sum(left), [0] * self.nodes
                continue
            if request and ready:
                found = unpack(dut.o_request.payload.shape(), place)
                requests.append([found["address"], found["length"] + 1, number in fails])
                number += 1
                self.requests.append(cycle)
            if data and data_ready:
                assert requests, "beats follow their request"
                found, current = unpack(dut.o_data.payload.shape(), beat), requests[0]
                assert found["strobe"] == (1 << size) - 1
                if not current[2]:
                    self.memory |= dict(enumerate(found["data"].to_bytes(size, "little"), start=current[0]))
                self.beats.append(cycle)
                current[0], current[1] = current[0] + size, current[1] - 1
                if not current[1]:
                    answers.append((cycle + draw.randint(*after), current[2]))
                    requests.popleft()
            for k in range(self.nodes):
                if offers[k] and readies[k]:
                    sent[k].append(words[k].popleft())
                    offers[k] = False
            if collected:
                assert len(sent[source]) == COMPLETION_WORDS
                self._keep(sent[source], tags[source], source, cycle)
                left[source] -= 1
            if took:
                self._keep_own(record, cycle)
                record, own = None, own - 1
            idle = idle + 1 if empty and not any(left) and not own else 0
            if idle > 30:
                break
        self.is_over = idle > 30

    def _keep(self, words, tag, cluster, cycle):
        found = np.frombuffer(b"".join(word.to_bytes(8, "little") for word in words), dtype=COMPLETION.dtype).copy()
        found["tag"], found["cluster"], found["lap"] = tag, cluster, 0
        self.records.append(found[0])
        self.collected.append(cycle)
        self.sources.append(cluster)

    def _keep_own(self, record, cycle):
        found = np.zeros(1, dtype=COMPLETION.dtype)
        for name, value in record.items():
            found[{"number": "address", "code": "error"}.get(name, name)] = value
        self.records.append(found[0])
        self.collected.append(cycle)
        self.sources.append(NO_CLUSTER)

    def check(self):
        """The last records are in the ring, each with its lap; all are counted."""
        bits = self._given[3]
        assert self.is_over
        assert self.completed == len(self.records)
        entries = 1 << bits
        ring = parse_completions(bytes(self.memory.get(RING + k, 0) for k in range(SIZE * min(entries, 64))))
        for number in range(max(0, len(self.records) - entries), len(self.records)):
            expected = self.records[number].copy()
            expected["lap"] = lap(number, bits)
            assert ring[number % entries] == expected
        if entries <= 64:
            assert has_arrived(ring, len(self.records) - 1)
            assert not has_arrived(ring, len(self.records))
        assert min(self.memory) >= RING
        assert max(self.memory) < RING + SIZE * entries


@pytest.fixture(scope="module", params=[64, pytest.param(512, marks=pytest.mark.sim)])
def writer(request):
    return Writer(request.param)


@pytest.mark.parametrize("width", WIDTHS)
def test_beats_of_all_widths(width):
    Writer(width).run((4, 3, 2), own=2, gaps=0.2, slow=0.2, stops={40}, fails={7}).check()


@pytest.mark.parametrize(("gaps", "slow", "after"), [(0, 0, (3, 9)), (0.5, 0.3, (1, 30)), (0.1, 0.8, (1, 1))])
def test_records_of_all_sources(writer, gaps, slow, after):
    writer.run((5, 3, 7), own=6, gaps=gaps, slow=slow, after=after).check()
    # The records `check` compares in their order; here how many each source had.
    assert Counter(writer.sources) == {0: 5, 1: 3, 2: 7, NO_CLUSTER: 6}


@pytest.mark.parametrize("ring_bits", [0, 1, 2, 5, 31])
def test_rings(ring_bits):
    """Of one entry, two, 2^n; laps count the times around."""
    Writer().run((6, 2, 1), own=2, ring_bits=ring_bits).check()


def test_a_reset_at_any_time(writer):
    """A record that was being collected is lost; those that were collected are written, once each."""
    for stop in range(2, 90, 11):
        aborts = stop % 2 == 1
        writer.run((3, 2, 3), own=3, seed=stop, stops={stop, stop + 41}, aborts=aborts, slow=0.3, gaps=0.1).check()
        found = Counter(writer.sources)
        assert found.total() == 11, f"seed {stop}"
        assert aborts or found == {0: 3, 1: 2, 2: 3, NO_CLUSTER: 3}, f"seed {stop}"
    for seed in range(4):
        # The first words come in the cycle of the reset and never again: none of them may be waited for.
        writer.run((1, 1, 1), seed=seed, stops={0}, aborts=True).check()
        assert Counter(writer.sources) == {NO_CLUSTER: 3}, f"seed {seed}"


@pytest.mark.parametrize("fails", [{0}, {3}, {2, 5}, {6}])
def test_a_record_that_cannot_be_written(writer, fails):
    """It and those behind it are written after a reset and a retry; the failure has its address."""
    writer.run((3, 2, 3), own=2, fails=fails, ring_bits=4).check()
    assert len(writer.failures) == len(fails)
    assert writer.failures[0][1] == RING + SIZE * min(fails)


@pytest.mark.sim
def test_sources_take_turns():
    """No source waits for more than one record of each other one."""
    writer = Writer()
    writer.run((8, 8, 8), own=8, gaps=0)
    writer.check()
    assert all(len(set(writer.sources[k:k + NODES + 1])) == NODES + 1 for k in range(0, 28))


def test_rate(writer):
    """A record for every 8 cycles, without a gap in the beats of 64 bits."""
    writer.run((6, 6, 6), own=6, after=(2, 2)).check()
    assert {b - a for a, b in pairwise(writer.collected)} == {COMPLETION_WORDS}
    assert writer.requests[0] == documented_latency(CompletionWriter, BASE) == CompletionWriter.latency
    if writer.config.memory.data_bits == 64:
        assert {b - a for a, b in pairwise(writer.beats)} == {1}
    assert len(writer.beats) == 24 * SIZE // writer.config.memory.beat_bytes


def test_records_wait_for_answers():
    """As many as are held."""
    writer = Writer().run((9, 9, 9), after=(400, 400), cycles=300)
    assert len(writer.records) == RECORDS
    assert writer.completed == 0


def test_short_requests():
    Writer(**{"memory.length_bits": 1}).run((3, 3, 3), own=1, late=0.9).check()


@pytest.mark.sim
def test_a_reset_at_any_time_of_short_requests():
    """Between the requests of a record, and between their answers: each record is written once, whole."""
    writer = Writer(**{"memory.length_bits": 1})
    for stop in range(9, 70, 6):
        writer.run((2, 2, 2), own=1, seed=stop, stops={stop, stop + 25}, after=(3, 15), slow=0.3).check()
        assert Counter(writer.sources) == {0: 2, 1: 2, 2: 2, NO_CLUSTER: 1}, f"stop {stop}"


@pytest.mark.parametrize("fails", [4, *(pytest.param(one, marks=pytest.mark.sim) for one in (6, 7))])
def test_a_record_is_written_again_if_any_of_its_requests_fails(fails):
    """Four requests of two beats each; it is known with the last answer."""
    writer = Writer(**{"memory.length_bits": 1}).run((3, 3, 3), own=1, fails={fails})
    writer.check()
    assert [address for _, address in writer.failures] == [RING + SIZE]


@pytest.mark.sim
def test_a_reset_forgets_the_answers_of_the_requests_before_it():
    """One of four requests was refused, the others had no answer yet: the record is written again after the reset."""
    writer = Writer(**{"memory.length_bits": 1})
    failures = []
    for stop in range(12, 28):
        writer.run((1,) * NODES, after=(4, 4), fails={0}, stops={stop}, cycles=400).check()
        failures.append(len(writer.failures))
    # It fails with the last answer, and not before; the refusal comes some cycles earlier.
    assert failures == [0] * 10 + [1] * 6


@pytest.mark.parametrize("counts", [(5,), (1,) * 5])
def test_other_numbers_of_clusters(counts):
    Writer(nodes=len(counts)).run(counts, own=3).check()
