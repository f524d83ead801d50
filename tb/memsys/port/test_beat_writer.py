"""Requests of whole groups of beats; answers, and beats that are dropped."""

from itertools import pairwise
from random import Random

from amaranth.sim import Simulator
from hypothesis import given
from hypothesis import strategies as st

from hw.memsys.port.beat_writer import BeatWriter
from tb.lib.bench import Bench, Vectors
from tb.lib.configurations import config_of
from tb.lib.responder import Responder, responder
from tb.lib.runner import SIMULATORS
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench
from tb.memsys.section_results import FULL_GROUP, requests_of
from tb.memsys.write_memory import WriteMemory


def beats_of(seed, config, count=60):
    """Beats of random requests."""
    random, number, beats = Random(seed), 0, []
    bits = config.memory.data_bits
    while len(beats) < count:
        number = random.choice((number, random.randrange(1 << 20)))
        for _ in range(random.choice((1, 1, 2, 5, FULL_GROUP, FULL_GROUP))):
            ends = number % FULL_GROUP == FULL_GROUP - 1
            beats.append({"number": number, "data": random.getrandbits(bits), "lanes": random.getrandbits(bits // 32),
                          "ends": int(ends)})
            number += 1
            if ends:
                break
        beats[-1]["ends"] = 1
    return beats


def strobed(beat, config):
    """As it goes to the port."""
    return {"data": beat["data"],
            "strobe": sum(15 << 4 * k for k in range(config.memory.data_bits // 32) if beat["lanes"] >> k & 1)}


def requests(beats, config):
    """Those of some beats."""
    return [{"address": those[0]["number"] * config.memory.beat_bytes, "length": len(those) - 1, "tag": 0}
            for those in requests_of(beats)]


class TestBeatWriter(Bench):
    """Nothing is changed but the strobes."""

    component = BeatWriter
    variants, splits, idle_limit = [{"memory.data_bits": bits} for bits in (64, 128)], False, 60

    def vectors(self, config):
        return self.drawn(config, 3)

    def drawn(self, config, seed):
        beats = beats_of(seed, config)
        requested = requests(beats, config)
        return Vectors(inputs={"i": beats}, ports={"discard": 0},
                       expected={"o_request": requested, "o_data": [strobed(beat, config) for beat in beats]},
                       about=WriteMemory(config.memory.data_bits, requested))

    @responder("o_data", "i_written", after=(0, 9))
    def data(self, value):
        return self.now.about.data(value)

    def check_times(self, given, cycles, latency):
        """One beat per cycle goes in and out; a request is offered after its last beat, its data after it."""
        entered, left, requested = cycles["i"], iter(cycles["o_data"]), iter(cycles["o_request"])
        assert {b - a for a, b in pairwise(entered)} == {1}
        ends = 0
        for those in requests_of(given.inputs["i"]):
            ends += len(those)
            came = [next(left, None) for _ in those]
            if ends > len(entered) or None in came:
                break
            request = next(requested)
            assert request - entered[ends - 1] == latency
            assert request < came[0]
            assert {b - a for a, b in pairwise(came)} <= {1}
        assert ends

    def unstalled(self, given, cycles, half):
        """The transfers of the first half."""
        return {"i": cycles["i"][:half["i"]], **{
            name: cycles[name][:len(cycles[name]) // 2] for name in ("o_request", "o_data")}}


class TestWideBeats(TestBeatWriter):
    """Beats of 512 bits."""

    test_in_amaranth = None
    simulators = SIMULATORS[1:]
    changes = {"memory.data_bits": 512}


CONFIG = config_of({"memory.data_bits": 64})
BENCH = ScheduleBench(BeatWriter(config=CONFIG), idle_limit=80, watched=("failed", "address", "idle"))
STALLS = st.lists(st.sampled_from((0, 0, 1, 5)), max_size=20)


def run(beats, memory, *, stalls=None, discard=0):
    """What comes out."""
    return BENCH.run(Schedule(items={"i": [(0, beat) for beat in beats]}, stalls=stalls or {}),
                     Responder("o_request", "i_written", memory.request),
                     Responder("o_data", "i_written", memory.data, after=(0, 30)), discard=discard)


@SETTINGS
@given(st.integers(0, 1 << 20), st.sets(st.integers(0, 20)), st.fixed_dictionaries({"o_request": STALLS,
                                                                                  "o_data": STALLS}))
def test_errors_are_reported_with_the_address_of_their_request(seed, fails, stalls):
    beats = beats_of(seed, CONFIG, 30)
    memory = WriteMemory(64, fails=fails)
    came = run(beats, memory, stalls=stalls)
    reported = [address for failed, address in zip(BENCH.history["failed"], BENCH.history["address"], strict=True)
            if failed]
    assert reported == [request["address"] for number, request in enumerate(came["o_request"]) if number in fails]
    assert came["o_request"] == requests(beats, CONFIG)
    last = BENCH.cycles["i_written"][-1]
    assert BENCH.history["idle"][last:] == [1] * len(BENCH.history["idle"][last:])
    assert not any(BENCH.history["idle"][BENCH.cycles["i"][0]:last])


def test_nothing_is_requested_while_beats_are_discarded():
    """Beats are accepted, one per cycle."""
    came = run(beats_of(1, CONFIG), WriteMemory(64), discard=1)
    assert came == {"o_request": [], "o_data": []}
    assert {b - a for a, b in pairwise(BENCH.cycles["i"])} == {1}
    assert set(BENCH.history["idle"]) == {1}


def test_an_offer_stays_while_beats_are_discarded():
    """It is accepted with its own beats; what waits behind it is dropped."""
    dut, beats, sent = BeatWriter(config=CONFIG), beats_of(4, CONFIG, 30), []
    (first, second, *_), (those, *_) = requests(beats, CONFIG), requests_of(beats)
    assert first != second

    async def bench(ctx):
        for beat in beats:
            ctx.set(dut.i.valid, 1)
            ctx.set(dut.i.payload, beat)
            await ctx.tick()
        ctx.set(dut.i.valid, 0)
        ctx.set(dut.o_data.ready, 1)
        for _ in range(4):
            offer = dut.o_request.payload
            assert (ctx.get(dut.o_request.valid), ctx.get(offer.address), ctx.get(offer.length)) == (
                1, first["address"], first["length"])
            await ctx.tick()
            ctx.set(dut.discard, 1)
        ctx.set(dut.o_request.ready, 1)
        await ctx.tick()
        for _ in range(len(beats) + 2):
            assert not ctx.get(dut.o_request.valid)
            *_, valid, data, strobe = await ctx.tick().sample(
                dut.o_data.valid, dut.o_data.payload.data, dut.o_data.payload.strobe)
            sent.extend([{"data": data, "strobe": strobe}] * valid)
        ctx.set(dut.i_written.valid, 1)
        await ctx.tick()
        assert ctx.get(dut.idle)

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    assert sent == [strobed(beat, CONFIG) for beat in those]
