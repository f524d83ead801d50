"""Registers under overlapping reads and writes, each transfer in the cycle that the rules predict."""

import random
from dataclasses import dataclass

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hw.registers.engine_registers import ADDRESS_BITS, ENGINE_REGISTERS
from hw.registers.register import Access, Field, Register
from hw.registers.registers import OKAY
from tb.lib.coverage import Coverage
from tb.lib.responder import responder
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench
from tb.registers.register_model import RegisterModel
from tb.registers.register_port import RegisterPort

SMALL = (
    Register(name="wide", access=Access.READ, width=50, about="A long number of the machine."),
    Register(name="count", access=Access.READ, about="A number of the machine."),
    Register(name="mode", access=Access.WRITE, width=5, about="Of the host.", reset=9,
             fields=(Field(name="low", width=2, about="bits"), Field(name="high", width=3, about="more bits"))),
    Register(name="base", access=Access.WRITE, width=44, about="A long one.", reset=7 << 35),
    Register(name="full", access=Access.WRITE, width=64, about="Two words."),
    Register(name="table", access=Access.WRITE, width=64, about="An address.", is_address=True),
    Register(name="go", access=Access.COMMAND, width=12, about="A command."),
    Register(name="run", access=Access.COMMAND, about="Another one."),
    Register(name="both", access=Access.CONTROL, width=7, about="A command that reads as a number of the machine."),
    Register(name="choice", access=Access.WRITE, width=3, about="Of few values.", most=5))
# Of addresses of main memory.
MEMORY_BITS = 41
TABLES = {"small": (SMALL, 7), "engine": (ENGINE_REGISTERS, ADDRESS_BITS)}
COMMANDS = {name: [one.name for one in table if one.access in (Access.COMMAND, Access.CONTROL)]
            for name, (table, _) in TABLES.items()}
# No two bits of a word have the same values in all of them.
CODES = [sum(1 << bit for bit in range(32) if bit >> k & 1) for k in range(5)]
CYCLES = st.sampled_from((0, 0, 0, 0, 1, 2, 3, 6))


@responder("o_window", "i_window", after=(1, 4))
def window(word):
    """The word with this number."""
    return [word * 0x10003 & 0xFFFFFFFF]


@dataclass(frozen=True)
class Accesses:
    """Writes as (gap of the address, gap of the data, address, data, strobe), reads as (gap, address), stalls of their
    answers and of the window."""

    writes: list
    reads: list
    stalls: dict

    @property
    def schedule(self):
        """The schedule for the bench."""
        return Schedule(stalls=self.stalls, items={
            "aw": [(gap, {"addr": address, "prot": gap % 8}) for gap, _, address, *_ in self.writes],
            "w": [(gap, {"data": data, "strb": strobe}) for _, gap, _, data, strobe in self.writes],
            "ar": [(gap, {"addr": address, "prot": gap % 8}) for gap, address in self.reads]})


def edges(table, address_bits):
    """Words beside the registers, and the first and the last one below and in the window."""
    window, end = 1 << address_bits - 3, 1 << address_bits - 2
    return [len(RegisterModel(table).words), window - 1, window, window + 3, end - 1]


def accesses(table, address_bits):
    """Accesses at random, most of them of registers; bytes without a strobe are anything."""
    words = RegisterModel(table).words
    host = [word for word, (one, _) in words.items() if one.access is not Access.READ]
    word = st.one_of(st.sampled_from(host), st.sampled_from(list(words)), st.sampled_from(edges(table, address_bits)))
    address = st.builds(lambda word, byte: 4 * word + byte, word, st.sampled_from((0, 0, 0, 1, 2, 3)))
    # Among them numbers of few bits, and addresses.
    data = st.one_of(st.integers(0, 9), st.integers(0, (1 << 26) - 1).map(lambda value: value << 6),
                     st.integers(0, (1 << 32) - 1))
    strobe = st.sampled_from((15, 0, *range(16)))

    def lists(element):
        # Lists of any length are mostly short.
        return st.one_of(st.lists(element, max_size=16), st.lists(element, min_size=8, max_size=16))

    stalls = st.fixed_dictionaries({name: lists(CYCLES) for name in ("b", "r", "o_window")})

    def some(targets):
        target = st.sampled_from(targets)
        return st.builds(Accesses, lists(st.tuples(CYCLES, CYCLES, target, data, strobe)),
                         lists(st.tuples(CYCLES, target)), stalls)

    # Of few addresses, so that reads meet writes.
    return st.lists(address, min_size=1, max_size=4).flatmap(some)


def stalled(stalls, number, before):
    """The first cycle in which a sink is ready after its transfer in cycle ``before``."""
    return before + 1 + (stalls[number] if number < len(stalls) else 0)


def expected_writes(model, one):
    """Of each write: cycles of address, data, effect and answer; answer, command, and all registers after it."""
    found, address, data, effect, answer = [], 0, 0, 0, 0
    for number, (gap, data_gap, target, value, strobe) in enumerate(one.writes):
        # Address and data of the next write are accepted when the one before has taken effect.
        address, data = max(address + 1 + gap, effect + 1), max(data + 1 + data_gap, effect + 1)
        effect = max(address + 1, data + 1, answer)
        answer = max(effect + 1, stalled(one.stalls["b"], number, answer))
        found.append((address, data, effect, answer, *model.write(target, value, strobe), dict(model.held)))
    return found


def expected_reads(table, limit, one, writes, replies):
    """Of each read: cycles of address and answer, the answer, and the cycle of the request to the window."""
    found, address, effect, answer, request, replies = [], 0, 0, 0, 0, iter(replies)
    requests = 0
    for number, (gap, target) in enumerate(one.reads):
        address = max(address + 1 + gap, effect + 1)
        if target >= limit // 2:
            request = max(address + 1, stalled(one.stalls["o_window"], requests, request))
            requests += 1
            effect = next(replies)
            assert effect >= max(request + 1, answer)
            (value,) = window(target // 4 % (limit // 8))
            replied = {"data": value, "resp": OKAY}
        else:
            effect = max(address + 1, answer)
            model = RegisterModel(table, memory_bits=MEMORY_BITS)
            # A write is visible from the cycle after it has taken effect.
            held = [after for *_, when, _, _, _, after in writes if when < effect]
            model.held = held[-1] if held else model.held
            replied = model.read(target, RegisterPort.machine(table, effect))
        answer = max(effect + 1, stalled(one.stalls["r"], number, answer))
        found.append((address, answer, replied, request if target >= limit // 2 else None))
    return found


def check(bench, name, one):
    """Everything that comes out, and when; the expected writes and reads."""
    table, address_bits = TABLES[name]
    came = bench.run(one.schedule, window)
    writes = expected_writes(RegisterModel(table, memory_bits=MEMORY_BITS), one)
    reads = expected_reads(table, 1 << address_bits, one, writes, bench.cycles["i_window"])
    expected = {
        "aw": [write[0] for write in writes], "w": [write[1] for write in writes], "b": [write[3] for write in writes],
        "ar": [read[0] for read in reads], "r": [read[1] for read in reads],
        "o_window": [read[3] for read in reads if read[3]]}
    assert {port: bench.cycles[port] for port in expected} == expected
    assert [answer["resp"] for answer in came["b"]] == [write[4] for write in writes]
    assert came["r"] == [read[2] for read in reads]
    for command in COMMANDS[name]:
        found = [(write[2], write[5][1]) for write in writes if write[5] and write[5][0] == command]
        assert list(zip(bench.cycles[command], came[command], strict=True)) == found
    return writes, reads


@pytest.fixture(scope="module", params=TABLES)
def bench(request):
    table, address_bits = TABLES[request.param]
    return request.param, ScheduleBench(RegisterPort(
        table, address_bits=address_bits, memory_bits=MEMORY_BITS))


CASES = ("address before data", "data before address", "both at once", "the next write waits", "the next read waits",
         "a write and a read answered at once", "a register is read as it changes",
         "a register is read when it has changed", "a refused write beside a read",
         "a write beside a read of the window")


def met(one, writes, reads):
    """Cases that a run has met."""
    for number, (address, data, effect, answer, *_) in enumerate(writes):
        yield CASES[0 if address < data else 1 if data < address else 2]
        if number and max(address, data) < writes[number - 1][3]:
            yield "the next write waits"
        target = one.writes[number][2]
        for (read, replied, *_), (_, at) in zip(reads, one.reads, strict=True):
            if replied == answer:
                yield "a write and a read answered at once"
            if at // 4 == target // 4 and replied - 1 in (effect, effect + 1):
                yield CASES[6 if replied - 1 == effect else 7]
            if writes[number][4] and read < effect < replied:
                yield "a refused write beside a read"
        if any(request and request < effect < replied for _, replied, _, request in reads):
            yield "a write beside a read of the window"
    if any(address < before for (address, *_), (_, before, *_) in zip(reads[1:], reads, strict=False)):
        yield "the next read waits"


def test_overlapping_accesses(bench):
    (name, simulation), coverage = bench, Coverage(CASES)

    @settings(SETTINGS, max_examples=60)
    @given(accesses(*TABLES[name]))
    def run(one):
        for case in met(one, *check(simulation, name, one)):
            coverage.hit(case)

    run()
    coverage.check()


def test_every_word_with_every_strobe(bench):
    """Its access, its width, and the bytes that a write keeps, also of words beside the registers and of the window."""
    (name, simulation), draw = bench, random.Random(1)
    for word in (*RegisterModel(TABLES[name][0]).words, *edges(*TABLES[name])):
        # All bits, no bit, each two bits once apart, what exceeds a few bits by one.
        values = [(1 << 32) - 1, 0, *CODES, *range(3, 8)]
        strobes = [15] * len(values)
        # The engine's registers are of the same kinds, whose single bits and bytes the small table has.
        if name == "small":
            values += [*(1 << bit for bit in range(32)), *(draw.getrandbits(32) for _ in range(16)),
                       *(draw.getrandbits(5) for _ in range(16))]
            strobes += [*[15] * 32, *draw.sample(range(16), 16), *draw.sample(range(16), 16)]
        # Each write waits for the answer of the one before.
        writes = [(0, 0, 4 * word, value, strobe) for value, strobe in zip(values, strobes, strict=True)]
        stalls = {"b": [5] * len(writes), "r": [], "o_window": []}
        check(simulation, name, Accesses(writes, [(1, 4 * word)] * (len(writes) * 7 // 5), stalls))
