"""What memory holds after the results of some sections."""

from collections import Counter
from dataclasses import replace
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from golden.engine.ctu.sector import Sector
from golden.engine.jobs.result_formats import HitFormat
from hw.memsys.port.beat_writer import DEPTH, REQUESTS
from hw.memsys.port.fault import Fault
from hw.memsys.results.result_writer import ResultWriter
from tb.lib.bench import Bench, Vectors
from tb.lib.configurations import config_of
from tb.lib.responder import Responder, responder
from tb.lib.runner import SIMULATORS
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench
from tb.lib.timing import documented_latency
from tb.memsys.section_results import FULL_GROUP, Packing, drawn_section, joined
from tb.memsys.write_memory import WriteMemory

# Regions of sections, so far from each other that none meets another one.
APART = 1 << 20
ALL_BITS = (64, 128, 256, 512)


def done(section):
    """What ends a section without a fault."""
    return {"code": Fault.NONE.value, "address": 0, "sums": len(section.sums) if section.command.sums else 0}


def expected_bytes(sections):
    """What memory holds afterwards."""
    return {address: byte for one in sections for address, byte in one.memory.items()}


class TestResultWriter(Bench):
    """Random sections, one after the other."""

    component = ResultWriter
    variants, splits, idle_limit = [{"memory.data_bits": bits} for bits in (64, 128)], False, 60
    count = 6

    def vectors(self, config):
        return self.drawn(config, 7)

    def drawn(self, config, seed):
        bits = config.memory.data_bits
        sections = [drawn_section(100 * seed + k, config, base=APART * (k + 1)) for k in range(self.count)]
        requests = [{**request, "tag": 0} for one in sections for request in one.requests(bits)]
        memory = WriteMemory(bits, requests)
        data = [{"data": None, "strobe": None}] * sum(request["length"] + 1 for request in requests)
        return Vectors(inputs=joined(sections), about=(sections, memory, bits), expected={
            "o_request": requests, "o_data": data, "o_done": list(map(done, sections))})

    @responder("o_data", "i_written", after=(0, 9))
    def data(self, value):
        return self.now.about[1].data(value)

    def check(self, given, came):
        super().check(given, came)
        sections, memory, _ = given.about
        assert memory.bytes == expected_bytes(sections)

    def latency(self, component, config):
        """From the command to the first hit."""
        return documented_latency(ResultWriter, config, first_row=0)

    def predict(self, given, trace, component, config):
        """Beats wait until those of their request are there; a section waits for the end of the one before."""
        sections, _, bits = given.about
        found, answers = {name: [] for name in trace.cycles}, [0] * REQUESTS + trace.offered["i_written"]
        requests, data, accepted, group = [0] * REQUESTS, [0] * DEPTH, 0, 0

        def leave(cycle, beat):
            nonlocal accepted, group
            cycle = max(cycle, data[accepted] + 1, requests[-REQUESTS] + 1)
            accepted, group = accepted + 1, group + 1
            if beat["ends"]:
                answered = answers[len(requests) - REQUESTS]
                requests.append(trace.ready("o_request", max(cycle, requests[-1], answered) + 1))
                for _ in range(group):
                    data.append(trace.ready("o_data", max(requests[-1], data[-1]) + 1))
                group = 0
            return cycle

        packing, extent, done = Packing(bits, trace, found, leave), -1, -1
        for one, offered in zip(sections, trace.offered["i"], strict=True):
            # The command is accepted a cycle before its extent is there, and that is when the one before has left.
            command = max(offered, found["i"][-1] + 1 if found["i"] else 0)
            found["i"].append(max(command + 2 + one.command.section.first_row.bit_length(), extent + 1))
            extent = max(found["i"][-1], done) + 1
            last = packing.add(one, extent)
            done = trace.ready("o_done", max(last, answers[len(requests) - 1]) + 2)
            found["o_done"].append(done)
        return found | {"o_request": requests[REQUESTS:], "o_data": data[DEPTH:], "i_written": answers[REQUESTS:]}


class TestWideBeats(TestResultWriter):
    """Beats of 512 bits."""

    test_in_amaranth = None
    simulators = SIMULATORS[1:]
    changes = {"memory.data_bits": 512}


CONFIGS = {bits: config_of({"memory.data_bits": bits}) for bits in ALL_BITS}
BENCHES = {bits: ScheduleBench(ResultWriter(config=config), idle_limit=60) for bits, config in CONFIGS.items()}
GAPS = st.lists(st.sampled_from((0, 0, 0, 1, 2, 7)), max_size=12)


def run(sections, bits, *, memory=None, gaps=(), stalls=None, delay=(0, 9), change=lambda items: items):
    """The memory, and what ends each section."""
    memory = memory or WriteMemory(bits)
    items = {name: [(gaps[number] if number < len(gaps) else 0, value) for number, value in enumerate(values)]
             for name, values in change(joined(sections)).items()}
    came = BENCHES[bits].run(Schedule(items=items, stalls=stalls or {}),
                             Responder("o_request", "i_written", memory.request),
                             Responder("o_data", "i_written", memory.data, after=delay))
    return memory, came["o_done"]


@SETTINGS
@given(st.sampled_from(ALL_BITS), st.lists(st.integers(0, 1 << 20), min_size=1, max_size=3), GAPS,
       st.fixed_dictionaries(dict.fromkeys(("o_request", "o_data", "o_done"), GAPS)))
def test_sections(bits, seeds, gaps, stalls):
    """Memory is golden's; nothing beside the results is written."""
    sections = [drawn_section(seed, CONFIGS[bits], base=APART * (k + 1)) for k, seed in enumerate(seeds)]
    memory, over = run(sections, bits, gaps=gaps, stalls=stalls)
    assert memory.bytes == expected_bytes(sections)
    assert over == [done(one) for one in sections]
    assert [{name: request[name] for name in ("address", "length")} for request in memory.requests] == [
        request for one in sections for request in one.requests(bits)]


@pytest.mark.parametrize("bits", [ALL_BITS[0], *(pytest.param(bits, marks=pytest.mark.sim) for bits in ALL_BITS[1:-1]),
                                  ALL_BITS[-1]])
@pytest.mark.parametrize("hit_format", HitFormat)
def test_rate(bits, hit_format):
    """A section as wide as its frustum is written in the longest requests, without a gap; so is a narrower one without
    a gap but for its requests.
    """
    interval = 2 if (bits, hit_format) == (64, HitFormat.FULL) else 1
    for rays in (Sector(0, 64, 0, 5), Sector(3, 64, 1, 3), Sector(7, 23, 2, 8)):
        one = drawn_section(bits, CONFIGS[bits], base=APART, columns=64, hit_format=hit_format, section=rays, sums=True,
                            hits=APART)
        memory, _ = run([one], bits, delay=(3, 3))
        cycles = BENCHES[bits].cycles
        assert {b - a for a, b in pairwise(cycles["i_hit"])} == {interval}
        assert memory.bytes == one.memory
        if rays.first_column == 0 and hit_format != HitFormat.NONE:
            beats = one.command.hit_format.bytes * 64 * 5 * 8 // bits
            lengths = Counter(request["length"] + 1 for request in memory.requests if request["address"] < 2 * APART)
            whole = beats - beats % FULL_GROUP
            assert lengths[FULL_GROUP] == whole // FULL_GROUP
        assert cycles["i_hit"][0] - 1 == documented_latency(
            ResultWriter, CONFIGS[bits], first_row=rays.first_row) + interval - 1
        assert cycles["o_done"][0] - cycles["i_written"][-1] == 2


@pytest.mark.parametrize("bits", [ALL_BITS[0], pytest.param(ALL_BITS[1], marks=pytest.mark.sim)])
@pytest.mark.parametrize("wrong", [3, *(pytest.param(other, marks=pytest.mark.sim) for other in (0, 6, 9))])
def test_errors_of_memory(bits, wrong):
    """End the section with the request's address; no other request begins, and the next section is right."""
    sections = [drawn_section(k, CONFIGS[bits], base=APART * (k + 1), columns=20, section=Sector(1, 19, 0, 9),
                              hit_format=HitFormat.FULL, sums=True) for k in range(3)]
    before = len(sections[0].requests(bits))
    for delay in (0, 25):
        memory, over = run(sections, bits, memory=WriteMemory(bits, fails={before + wrong}), delay=delay)
        failed = memory.requests[before + wrong]
        assert over == [done(sections[0]), {"code": Fault.WRITE_REPLY.value, "address": failed["address"], "sums": 0},
                        done(sections[2])]
        right = expected_bytes(sections)
        assert {address: right.get(address) for address in memory.bytes} == memory.bytes
        assert {address: memory.bytes.get(address) for one in sections[::2] for address in one.memory} == (
            expected_bytes(sections[::2]))
        cycles = BENCHES[bits].cycles
        answer = cycles["i_written"][before + wrong]
        late = [cycle for cycle in cycles["o_request"] if answer + 1 < cycle < cycles["o_done"][1]]
        # One that was offered stays.
        assert len(late) <= 1
        hits = cycles["i_hit"][len(sections[0].hit_items):len(sections[0].hit_items) + len(sections[1].hit_items)]
        assert {b - a for a, b in pairwise(cycle for cycle in hits if cycle > answer + 1)} <= {1, 2}


@pytest.mark.parametrize(("number", "hit_format"), [*zip((0, 1, 4, 8), HitFormat, strict=True)])
def test_overflow(number, hit_format):
    """Of a sum: the section ends with its patch; but not of one that is not written, whatever hits are."""
    sections = [drawn_section(40 + k, CONFIGS[64], base=APART * (k + 1), sums=k < 2, hit_format=hit_format)
                for k in range(3)]
    sections = [replace(one, patches=[*range(9, 18)], sums=[3] * 9) for one in sections]

    def change(items):
        for at in 9 + number, 18 + number:
            items["i_sum"][at] = {**items["i_sum"][at], "overflow": 1}
        return items

    memory, over = run(sections, 64, change=change)
    assert over == [done(sections[0]), {"code": Fault.OVERFLOW.value, "address": 9 + number, "sums": 0},
                    done(sections[2])]
    right = expected_bytes(sections)
    assert {address: right.get(address) for address in memory.bytes} == memory.bytes
    assert not any(address >= sections[1].command.sums_address + 8 * number for address in memory.bytes
                   if address in sections[1].memory and address >= sections[1].command.sums_address)
    assert {address: memory.bytes.get(address) for address in sections[2].memory} == sections[2].memory


@pytest.mark.parametrize("hit_format", HitFormat)
def test_the_last_hit_must_end_a_row(hit_format):
    """Else the section ends with a fault."""
    sections = [drawn_section(60 + k, CONFIGS[64], base=APART * (k + 1), columns=9, section=Sector(0, 8, 0, 2),
                              hit_format=hit_format) for k in range(2)]

    def change(items):
        items["i_hit"] = [*items["i_hit"][:10], {**items["i_hit"][10], "last": 1}, *items["i_hit"][16:]]
        return items

    memory, over = run(sections, 64, change=change)
    assert over == [{"code": Fault.NO_RECORD.value, "address": 0, "sums": 0}, done(sections[1])]
    assert {address: byte for address, byte in memory.bytes.items() if address >= 2 * APART} == sections[1].memory


def test_the_first_of_several_errors_counts():
    """A request that memory refuses and a sum that overflows, whichever comes first: the request if both come at once.
    Hits that do not end a row come before both.
    """
    one = replace(drawn_section(71, CONFIGS[64], base=APART, columns=9, section=Sector(0, 9, 0, 2),
                                hit_format=HitFormat.FULL, sums=True), patches=[*range(9, 18)], sums=[3] * 9)
    last = sum(request["address"] < one.command.sums_address for request in one.requests(64)) - 1

    def overflow(items):
        items["i_sum"][4] = {**items["i_sum"][4], "overflow": 1}
        return items

    def end_early(items):
        items["i_hit"] = [*items["i_hit"][:10], {**items["i_hit"][10], "last": 1}]
        return overflow(items)

    orders = set()
    for delay in range(0, 24, 2):
        memory, (over,) = run([one], 64, memory=WriteMemory(64, fails={last}), delay=delay, gaps=[0, 0, 0, 0, 16],
                              change=overflow)
        refused, overflows = BENCHES[64].cycles["i_written"][last], BENCHES[64].cycles["i_sum"][4]
        orders.add((refused > overflows) - (refused < overflows))
        code, address = ((Fault.WRITE_REPLY, memory.requests[last]["address"]) if refused <= overflows
                         else (Fault.OVERFLOW, one.patches[4]))
        assert over == {"code": code.value, "address": address, "sums": 0}, f"{delay} cycles"
    assert orders == {-1, 0, 1}
    for fails in (), {0}:
        _, (over,) = run([one], 64, memory=WriteMemory(64, fails=set(fails)), delay=60, change=end_early)
        assert over == {"code": Fault.NO_RECORD.value, "address": 0, "sums": 0}
