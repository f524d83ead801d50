from amaranth.hdl import Assert, Assume, Const, Cover, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import PRESETS
from hw.memsys.bus.cache import Cache
from hw.memsys.bus.cache_policy import CachePolicy
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Claim, Control, declare
from tb.formal.stream_rules import add_rules

# Two keys: one that is followed, and all others.
KEY, WIDTH, FETCHES = 1, 1, 2
# The request that is followed, and where it would go.
TAG = StructLayout({"mark": 1, "line": 1})
CONFIG = PRESETS["tiny"].replace({"memsys.cache_ways": 2, "memsys.lfu_lines": 2, "memsys.lfu_count_bits": 2,
                                  "memsys.cache_generation_bits": 2, "memsys.cache_fetches": FETCHES})


def contract(m, bench, dut):
    """Each request is answered once, in order, with what memory held for its key when the request was taken.

    One request, any request, is followed. Memory holds a record for its key that changes with every invalidation, and
    anything for the others; it answers whenever and in whatever order it likes. So the answer must have been fetched
    since the last invalidation, whatever else has been in the lines; the first request after one is a miss. What
    the cache gives keeps the rules of streams.
    """
    for given in (dut.i, dut.i_invalidate):
        add_rules(m, given, Assume)
    for given in (dut.o, dut.o_fetch):
        add_rules(m, given, Assert)
    key, data, fails, chosen = bench.choose(m, KEY, "key"), Signal(WIDTH), Signal(), Signal()
    empties, requests, answers, fetches = (transfers(port) for port in (dut.i_invalidate, dut.i, dut.o, dut.o_fetch))
    m.d.sync += chosen.eq(1)
    with m.If(~chosen | empties):
        m.d.sync += [data.eq(bench.free(WIDTH, "data")), fails.eq(bench.free(1, "fails"))]

    # Memory: its outstanding requests, and its answers.
    awaited, mine = Signal(FETCHES), Signal(FETCHES)
    slot, fill = dut.o_fetch.payload.slot, dut.i_fill.payload
    with m.If(dut.i_fill.valid):
        m.d.comb += Assume(awaited.bit_select(fill.slot, 1))
        m.d.sync += awaited.bit_select(fill.slot, 1).eq(0)
        with m.If(mine.bit_select(fill.slot, 1)):
            m.d.comb += [Assume(fill.data == data), Assume(fill.error == fails)]
    with m.If(fetches):
        m.d.comb += Assert(~awaited.bit_select(slot, 1), "slot")
        m.d.sync += [awaited.bit_select(slot, 1).eq(1), mine.bit_select(slot, 1).eq(dut.o_fetch.payload.key == key)]

    # The request that is followed.
    inside, ahead, follows, expected = Signal(5), Signal(5), Signal(), Signal(WIDTH + 1)
    first, must_miss, marked = Signal(init=1), Signal(), Signal()
    m.d.comb += [marked.eq(bench.free(1, "marks") & ~follows & (dut.i.payload.key == key)),
                 Assume(dut.i.payload.tag.mark == marked)]
    m.d.sync += inside.eq(inside + requests - answers)
    with m.If(requests & (dut.i.payload.key == key)):
        m.d.sync += first.eq(0)
    with m.If(empties):
        m.d.sync += first.eq(1)
    got = dut.o.payload
    with m.If(answers):
        m.d.comb += [Assert(inside != 0, "once"), Assert(got.tag.mark == (follows & (ahead == 0)), "order")]
    with m.If(follows & answers):
        m.d.sync += ahead.eq(ahead - 1)
        with m.If(ahead == 0):
            m.d.sync += follows.eq(0)
            m.d.comb += [Assert(got.error == expected[-1], "error"), Assert(got.record[0] == expected[:-1], "data"),
                         Assert(~(must_miss & got.hit), "miss"), Cover(got.hit & (got.record[0] != 0), "hit")]
    with m.If(requests & marked):
        m.d.sync += [follows.eq(1), ahead.eq(inside - answers), expected[:-1].eq(data), expected[-1].eq(fails),
                     must_miss.eq(first)]


class AnyPlacement(wiring.Component):
    """Puts what it does not have into any line: the one that the tag says. A start ``empties`` it, or does not."""

    latency = 1

    def __init__(self, *, lines, key, tag, empties=True):
        self._lines, self._key, self._empties = lines, key, empties
        super().__init__({
            "i_start": In(stream.Signature(0, always_ready=True)),
            "i": In(stream.Signature(StructLayout({"tag": tag, "key": key}), always_ready=True)),
            "o": Out(stream.Signature(StructLayout({"tag": tag, "line": range(lines), "hit": 1}), always_ready=True))})

    def elaborate(self, platform):
        m = Module()
        keys, full = [Signal(self._key, name=f"key_{k}") for k in range(self._lines)], Signal(self._lines)
        head = self.i.payload
        found = [full[k] & (keys[k] == head.key) for k in range(self._lines)]
        hit, line = Signal(), Signal(range(self._lines))
        m.d.comb += [hit.eq(sum(found) != 0), line.eq(head.tag.tag.line)]
        for k, here in enumerate(found):
            with m.If(here):
                m.d.comb += line.eq(k)
            with m.If(self.i.valid & (line == k)):
                m.d.sync += [keys[k].eq(head.key), full[k].eq(1)]
        with m.If(self.i_start.valid & self._empties):
            m.d.sync += full.eq(0)
        m.d.sync += [self.o.valid.eq(self.i.valid), self.o.payload.tag.eq(head.tag), self.o.payload.line.eq(line),
                     self.o.payload.hit.eq(hit)]
        return m


class Narrow(Cache):
    """With a smaller capacity, so that it is full soon."""

    capacity = 3


class Anywhere(Narrow):
    """With whatever placement there can be."""

    def _placements(self):
        yield "lfu", AnyPlacement(lines=self._lines, key=self._key, tag=self._request)


class Unseen(Anywhere):
    """Reads a line also while it is being written."""

    def _repeats(self, answer, line):
        return Const(0)


class Hasty(Anywhere):
    """Shows what the answer in front shows whatever line it is in."""

    def _repeats(self, answer, line):
        return answer.hit


class Stale(Narrow):
    """An invalidation leaves everything in its line."""

    def _placements(self):
        yield "lfu", AnyPlacement(lines=self._lines, key=self._key, tag=self._request, empties=False)


def make(kind=Anywhere, policy=CachePolicy.LFU, lines=2):
    return Bench(contract, kind(WIDTH, beats=1, config=CONFIG, lines=lines, key=KEY, tag=TAG, policies=(policy,)))


# Enough for an invalidation between requests, and for a hit after it, with a placement that answers at once.
test_cache = declare(
    make, cycles=14, engine="abc bmc3", covers_nightly=True,
    claims=[Claim(), Claim(cycles=16, nightly=True),
            # Their placements take longer to a hit.
            *(Claim(kind=Narrow, policy=policy, lines=lines, cycles=cycles, nightly=True) for policy, lines, cycles in (
                (CachePolicy.DIRECT, 2, 17), (CachePolicy.LRU, 4, 17), (CachePolicy.LFU, 2, 19)))],
    controls={
        "an invalidation leaves everything": Control("miss", kind=Stale),
        "reads a line that is written": Control("data", kind=Unseen, nightly=True),
        "shows the line of the answer in front": Control("data", kind=Hasty, nightly=True),
        "answers before it has been filled": Control(
            "data", {"o__valid": lambda dut: dut.o.valid | dut.i_fill.valid}, nightly=True),
        "loses an answer": Control(
            "order", {"o__valid": lambda dut: dut.o.valid & ~(dut.o.payload.hit & dut.i.valid)}, nightly=True),
        "fetches into a slot in use": Control(
            "slot", {"o_fetch__payload": lambda dut: dut.o_fetch.payload.as_value() & ~1}, nightly=True),
    })
