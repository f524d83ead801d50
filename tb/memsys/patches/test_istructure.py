from itertools import pairwise

import cocotb
import numpy as np
import pytest
from cocotb.triggers import ClockCycles, RisingEdge

from golden.engine.config import PRESETS
from golden.engine.stimulus import block
from golden.engine.stimulus.memsys.istructure import COUNT, DEFERRED, READ, START
from hw.lib.payload import pack, unpack
from hw.memsys.patches.istructure import IStructure
from tb.lib.clocking import reset, start
from tb.lib.coverage import Coverage
from tb.lib.no_x import assert_known
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.simulator import simulator_of
from tb.lib.stall_patterns import STALL_PAIRS, STALLS
from tb.lib.stream import Monitor, Sink, Source
from tb.lib.timing import documented_latency
from tb.memsys.patches.any_order import answers

STREAMS = ("i_start", "i_read", "i_write", "o_read", "o_refused")
VERSION_BITS, TAG_BITS = 2, 16
# Cycles from a write to the first read that waited for it, and to its refusal.
RELEASE, REFUSAL = 8, 4
CASES = ("a read finds its data", "a read waits", "several wait for one location", "all entries are taken",
         "a read waits for an entry", "a write is refused", "tags run out", "writes come while reads are released")


def make():
    return IStructure(16, depth=COUNT, version_bits=VERSION_BITS, deferred=DEFERRED, tag=TAG_BITS)


SHAPES = {name: make().signature.members[name].signature.members["payload"].shape
          for name in ("i_read", "i_write", "o_read")}


def reads_of(addresses, tags=None):
    """Reads; tags count from 0 on unless others are given."""
    return [pack(SHAPES["i_read"], {"address": int(address), "tag": int(tag)})
            for address, tag in zip(addresses, range(len(addresses)) if tags is None else tags, strict=True)]


def writes_of(addresses, data):
    return [pack(SHAPES["i_write"], {"address": int(address), "data": int(value)})
            for address, value in zip(addresses, data, strict=True)]


class Bench:
    """The streams of an I-structure, and what has been seen at them."""

    def __init__(self, dut, *, accesses="none", sink="none"):
        seed = options()["seed"]
        self.dut, self._edge = dut, RisingEdge(dut.clk)
        self.start = Source(dut, "i_start")
        self.read, self.write = (Source(dut, name, stalls=STALLS[accesses](seed + k))
                                 for k, name in enumerate(("i_read", "i_write")))
        self.taken = {name: Monitor(dut, name) for name in ("i_start", "i_read", "i_write")}
        self.answer = Sink(dut, "o_read", stalls=STALLS[sink](seed + 2))
        self.refused = Monitor(dut, "o_refused")

    def stop(self):
        for monitor in (*self.taken.values(), self.answer, self.refused):
            monitor.stop()
        for source in (self.start, self.read, self.write):
            source.valid.value = 0

    @property
    def answers(self):
        """Tags and data that have come."""
        found = [unpack(SHAPES["o_read"], item) for item in self.answer.items]
        return [(answer["tag"], answer["data"]) for answer in found]

    async def until_answered(self, count):
        while len(self.answer.items) < count:
            await self._edge
        await ClockCycles(self.dut.clk, RELEASE + 2)

    async def version(self, random, *, reads=48, slow_writes=True):
        """A version of random reads and writes, as golden says; returns its reads and writes."""
        before = len(self.answer.items), len(self.refused.items)
        read = random.integers(COUNT, size=reads)
        write = np.concatenate([random.permutation(COUNT), random.integers(COUNT, size=6)])
        # Refused ones among the others.
        write = write[np.argsort(random.random(len(write)), kind="stable")]
        data, tags = random.integers(1 << 16, size=len(write)), random.permutation(1 << TAG_BITS)[:reads]
        await self.start.send([0])
        reading = cocotb.start_soon(self.read.send(reads_of(read, tags)))
        for item in writes_of(write, data):
            if slow_writes:
                await ClockCycles(self.dut.clk, int(random.integers(1, 12)))
            await self.write.send([item])
        await reading
        await self.until_answered(before[0] + reads)
        answered, values, refused = answers(read, write, data)
        assert answered.all()
        got = self.answers[before[0]:]
        expected = sorted(zip(tags.tolist(), values.tolist(), strict=True))
        assert sorted(got) == expected, "each read must be answered once, with its data, when its location is written"
        assert self.refused.items[before[1]:] == write[refused].tolist()


class Watch:
    """Counts the cases of the traffic."""

    def __init__(self, dut):
        self.coverage, self._dut = Coverage(CASES), dut
        cocotb.start_soon(self._run())

    async def _run(self):
        dut, edge, present, read_at, starts = self._dut, RisingEdge(self._dut.clk), {}, {}, 0
        while True:
            await edge
            waiting = int(dut.waiting.value)
            write = unpack(SHAPES["i_write"], int(dut.i_write__payload.value))["address"] if (
                int(dut.i_write__valid.value) and int(dut.i_write__ready.value)) else None
            self.coverage.hit_all({
                "all entries are taken": waiting == DEFERRED,
                "a read waits for an entry": waiting == DEFERRED and int(dut.i_read__valid.value)
                and not int(dut.i_read__ready.value),
                "a write is refused": write in present,
                "writes come while reads are released": write is not None and bool(int(dut.o_read__valid.value))})
            if write is not None:
                present[write] = True
            if int(dut.i_read__valid.value) and int(dut.i_read__ready.value):
                address = unpack(SHAPES["i_read"], int(dut.i_read__payload.value))["address"]
                self.coverage.hit("a read finds its data" if address in present else "a read waits")
                if address not in present:
                    read_at[address] = read_at.get(address, 0) + 1
                    self.coverage.hit("several wait for one location", read_at[address] > 1)
            if int(dut.i_start__valid.value) and int(dut.i_start__ready.value):
                present, read_at, starts = {}, {}, starts + 1
                self.coverage.hit("tags run out", starts > (1 << VERSION_BITS) - 1)


@cocotb.test()
async def every_pair_of_stalls(dut):
    """Versions under each pair of stall patterns are answered as golden says."""
    await start(dut, cycles=100_000)
    random, watch = np.random.default_rng(options()["seed"]), None
    for accesses, sink in STALL_PAIRS:
        bench = Bench(dut, accesses=accesses, sink=sink)
        await RisingEdge(dut.clk)
        watch = watch or Watch(dut)
        assert_known(dut, STREAMS)
        await bench.version(random, slow_writes=sink != "bursts")
        bench.stop()
    watch.coverage.check()


@cocotb.test()
async def one_after_the_other(dut):
    """Golden's stimulus, each access when the one before it is over: the same answers, in the same order."""
    await start(dut, cycles=20_000)
    bench = Bench(dut)
    of = block("memsys.istructure")[1]
    given = of.draw(np.random.default_rng(options()["seed"]), 400, PRESETS["tiny"])
    expected = of.expect(given, PRESETS["tiny"])
    await bench.start.send([0])
    for number, kind in enumerate(given["kind"].tolist()):
        address, value = int(given["address"][number]), int(given["value"][number])
        came, refused = len(bench.answer.items), len(bench.refused.items)
        if kind == START and expected["taken"][number]:
            await bench.start.send([0])
        elif kind == READ and expected["taken"][number]:
            await bench.read.send(reads_of([address], [value]))
        elif kind not in (START, READ):
            await bench.write.send(writes_of([address], [value]))
        else:
            # A read without a free entry would stay, and so would a start.
            continue
        await ClockCycles(dut.clk, RELEASE + DEFERRED + 1)
        tags = [int(tag) for tag in expected["answered"][number] if tag >= 0]
        assert bench.answers[came:] == [(tag, int(expected["data"][number])) for tag in tags], number
        assert len(bench.refused.items) - refused == (kind not in (START, READ) and not expected["taken"][number])
        assert int(dut.waiting.value) == expected["waiting"][number]


@cocotb.test()
async def a_version_behind_writes(dut):
    """Writes that are in flight when a version is requested are of the version before."""
    await start(dut, cycles=5_000)
    bench = Bench(dut)
    await bench.start.send([0])
    for apart in range(6):
        came = len(bench.answer.items)
        await bench.write.send(writes_of([5, 6], [apart, apart]))
        await ClockCycles(dut.clk, apart)
        await bench.start.send([0])
        await bench.read.send(reads_of([6, 5], [1, 2]))
        await ClockCycles(dut.clk, 2 * RELEASE)
        assert len(bench.answer.items) == came, "what was written is of the version before"
        await bench.write.send(writes_of([5, 6], [100 + apart, 200 + apart]))
        await ClockCycles(dut.clk, 2 * RELEASE)
        assert bench.answers[came:] == [(2, 100 + apart), (1, 200 + apart)]


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing of before a reset comes out, whatever was in flight: reads, a chain, a sweep."""
    await start(dut, cycles=20_000)
    random = np.random.default_rng(options()["seed"])
    for cut in (1, 2, 3, 5, 8, 13, 21, 34):
        bench = Bench(dut)
        await bench.start.send([0])
        tasks = [cocotb.start_soon(bench.read.send(reads_of(random.integers(COUNT, size=30)))),
                 cocotb.start_soon(bench.write.send(writes_of(range(COUNT), range(COUNT))))]
        if cut % 2:
            # The store is full, and nobody writes.
            tasks.pop().cancel()
        await ClockCycles(dut.clk, cut)
        for task in tasks:
            task.cancel()
        bench.stop()
        await reset(dut)
        bench = Bench(dut)
        await ClockCycles(dut.clk, RELEASE + DEFERRED)
        assert not bench.answer.items
        assert not int(dut.waiting.value)
        sweep = cocotb.start_soon(bench.start.send([0]))
        await ClockCycles(dut.clk, min(cut, COUNT))
        sweep.cancel()
        dut.i_start__valid.value = 0
        await reset(dut)
        await bench.version(random)
        bench.stop()


@cocotb.test()
async def one_access_per_cycle(dut):
    """Reads, writes and answers go one per cycle, after the latencies that the docstring states."""
    await start(dut, cycles=2_000)
    bench = Bench(dut)
    await bench.start.send([0])
    cocotb.start_soon(bench.write.send(writes_of([k % COUNT for k in range(60)], range(60))))
    await RisingEdge(dut.clk)
    await bench.read.send(reads_of([k % COUNT for k in range(60)]))
    await bench.until_answered(60)
    for name in ("i_read", "i_write"):
        assert {b - a for a, b in pairwise(bench.taken[name].cycles)} == {1}, f"{name} must be taken without a gap"
    assert {b - a for a, b in pairwise(bench.answer.cycles)} == {1}, "answers must come without a gap"
    assert bench.answers == [(k, k % COUNT) for k in range(60)]
    assert bench.taken["i_write"].cycles[0] == bench.taken["i_start"].cycles[0] + 1, "nothing waits behind a start"
    assert bench.answer.cycles[0] - bench.taken["i_read"].cycles[0] == documented_latency(IStructure, PRESETS["tiny"])
    assert bench.refused.cycles[0] - bench.taken["i_write"].cycles[COUNT] == REFUSAL
    assert len(bench.refused.items) == 60 - COUNT


@cocotb.test()
async def a_full_store(dut):
    """It is released without a bubble, chain after chain, while writes go on; only reads wait for a free entry."""
    await start(dut, cycles=2_000)
    for addresses in ([0] * DEFERRED, [k % 2 for k in range(DEFERRED)], list(range(DEFERRED))):
        bench = Bench(dut)
        await bench.start.send([0])
        reading = cocotb.start_soon(bench.read.send(reads_of([*addresses, COUNT - 1, COUNT - 2, COUNT - 1, *range(8)])))
        await ClockCycles(dut.clk, 40)
        assert int(dut.waiting.value) == DEFERRED
        assert not bench.answer.items
        stuck = len(bench.taken["i_read"].items)
        # The location of the first read without an entry is written: it is answered, though the store stays full.
        await bench.write.send(writes_of([COUNT - 1], [77]))
        await ClockCycles(dut.clk, 20)
        assert bench.answers == [(DEFERRED, 77)]
        assert int(dut.waiting.value) == DEFERRED
        assert len(bench.taken["i_read"].items) == stuck + 1, "the next read without an entry must wait where it is"
        before, came = len(bench.taken["i_write"].cycles), len(bench.answer.items)
        await bench.write.send(writes_of(range(COUNT), range(COUNT)))
        await reading
        await bench.until_answered(DEFERRED + 11)
        cycles = bench.taken["i_write"].cycles[before:]
        assert cycles == list(range(cycles[0], cycles[0] + COUNT)), "writes must not stall"
        released = bench.answer.cycles[came:came + DEFERRED]
        assert released == list(range(cycles[0] + RELEASE, cycles[0] + RELEASE + DEFERRED)), "releases without a bubble"
        # Golden's order: locations are written in turn, and the reads of each are served first come, first served.
        assert bench.answers[came:came + DEFERRED] == sorted(enumerate(addresses), key=lambda read: (read[1], read[0]))
        bench.stop()


@cocotb.test()
async def versions(dut):
    """Tags are cleared when they run out and not before; a version waits for the reads of the last one."""
    await start(dut, cycles=2_000)
    bench = Bench(dut)
    # Nothing is taken before the first version.
    early = cocotb.start_soon(bench.read.send(reads_of([3])))
    await ClockCycles(dut.clk, 10)
    assert not early.done()
    cycles, last = [], (1 << VERSION_BITS) - 1
    for number in range(3 * last + 1):
        begin = len(bench.taken["i_start"].cycles)
        edge = RisingEdge(dut.clk)
        waited, starting = 0, cocotb.start_soon(bench.start.send([0]))
        while len(bench.taken["i_start"].cycles) == begin:
            await edge
            waited += 1
        await starting
        cycles.append(waited)
        # In each version only some of the locations are written.
        await bench.write.send(writes_of([number % 3, 3], [number, 100 + number]))
        await ClockCycles(dut.clk, 16)
        assert bench.answers == [(0, 100)]
    sweep = cycles[0] - cycles[1]
    assert sweep == COUNT
    assert cycles == [cycles[1] + sweep * (number % last == 0) for number in range(3 * last + 1)]

    await bench.read.send(reads_of([5], [9]))
    starting = cocotb.start_soon(bench.start.send([0]))
    await ClockCycles(dut.clk, 30)
    assert not starting.done(), "a version must not begin while a read waits"
    later = cocotb.start_soon(bench.read.send(reads_of([3], [10])))
    await ClockCycles(dut.clk, 10)
    assert not later.done(), "reads of the next version must wait"
    await bench.write.send(writes_of([5], [55]))
    await starting
    await later
    await ClockCycles(dut.clk, 20)
    assert bench.answers == [(0, 100), (9, 55)]
    assert int(dut.waiting.value) == 1
    await bench.write.send(writes_of([3], [33]))
    await bench.until_answered(3)
    assert bench.answers[-1] == (10, 33)
    assert not bench.refused.items


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    simulate(make(), __name__, simulator=simulator)


@pytest.mark.parametrize(("name", "message"), [
    ("depth", "Depth"), ("version_bits", "Version bits"), ("deferred", "Deferred")])
def test_init_wrong_size(name, message):
    with pytest.raises(ValueError, match=f"^{message} must be at least 1, not 0$"):
        IStructure(8, tag=4, **{"depth": 4, "version_bits": 1, "deferred": 2, name: 0})


@pytest.mark.parametrize(("seed", "ready"), [
    (2, 0.5), *(pytest.param(*one, marks=pytest.mark.sim) for one in ((1, 1.0), (3, 0.8)))])
def test_renewed_locations(seed, ready):
    """Reads, writes and renewals in any order: each read is answered once, with data that its location held then."""
    depth, cycles = 4, 800
    dut, random = IStructure(16, depth=depth, version_bits=VERSION_BITS, deferred=8, tag=12, renews=True), \
        np.random.default_rng(seed)
    # By location: the present data, and from and to which cycle each datum was there. By tag: location and cycle.
    present, spans, read_at, refusals, coverage = {}, {}, {}, [], Coverage(
        ["a read waits", "a read waits for a renewed location", "a write of a renewed location", "a write is refused"])

    async def drive(ctx):
        ctx.set(dut.i_start.valid, 1)
        await ctx.tick().until(dut.i_start.ready)
        ctx.set(dut.i_start.valid, 0)
        offers, number, refused, renewals = {}, 0, 0, set()
        for cycle in range(cycles + 600):
            for name, rate in (("i_read", 0.5), ("i_write", 0.25), ("i_renew", 0.2)):
                # In the end all locations are written, until nothing waits.
                closes = cycle >= cycles
                port = getattr(dut, name)
                if name not in offers and (name == "i_write" if closes else random.random() < rate):
                    address = cycle % depth if closes else int(random.integers(depth))
                    offers[name] = address
                    number += 1
                    ctx.set(port.payload, address if name == "i_renew" else {
                        "address": address, **({"tag": number} if name == "i_read" else {"data": number})})
                ctx.set(port.valid, name in offers)
            ctx.set(dut.o_read.ready, random.random() < ready)
            *_, read, write, renew, came, wrote, answers_now, answer, refuses, which, waiting = await ctx.tick().sample(
                *(port.valid & port.ready for port in (dut.i_read, dut.i_write, dut.i_renew)), dut.i_read.payload,
                dut.i_write.payload, dut.o_read.valid & dut.o_read.ready, dut.o_read.payload, dut.o_refused.valid,
                dut.o_refused.payload, dut.waiting)
            coverage.hit("a read waits", waiting > 0)
            if renew:
                address = offers.pop("i_renew")
                if address in present:
                    spans[address, present.pop(address)][1] = cycle
                    renewals.add(address)
            if read:
                read_at[came["tag"]] = (offers.pop("i_read"), cycle)
                coverage.hit("a read waits for a renewed location", came["address"] in renewals - set(present))
            if write:
                address, data = offers.pop("i_write"), wrote["data"]
                coverage.hit("a write is refused", address in present)
                if address in present:
                    refusals.append(address)
                else:
                    coverage.hit("a write of a renewed location", address in renewals)
                    present[address], spans[address, data] = data, [cycle, None]
            if refuses:
                assert which == refusals[refused]
                refused += 1
            if answers_now:
                address, since = read_at.pop(answer["tag"])
                begin, end = spans[address, answer["data"]]
                assert begin <= cycle
                assert end is None or end >= since, "a read must not see what was renewed before it came"
        assert not read_at, "each read must be answered"
        assert refused >= len(refusals) - REFUSAL

    simulator_of(dut, drive).run()
    coverage.check()
