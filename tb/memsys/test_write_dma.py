from pathlib import Path

import cocotb
import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from cocotb.triggers import ClockCycles, RisingEdge
from cocotb.utils import get_sim_time

from golden.cast.fixed_hits import FixedHits
from golden.ctu.sector import Sector
from golden.frustum import Hemisphere
from golden.icu.collector import collect
from golden.memory_map import from_bytes, machine_image
from golden.schedule.phase import schedule
from hw.memsys.axi_signature import AxiSignature
from hw.memsys.fault import Fault
from hw.memsys.main_memory_port import MainMemoryPort
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.result_formats import ResultKind
from hw.memsys.write_dma import WriteDma
from tb.golden.schedule.scenes import CONFIG, case
from tb.lib.clocking import PERIOD, reset, start
from tb.lib.configurations import config_of
from tb.lib.no_x import assert_known
from tb.lib.payload import pack, unpack
from tb.lib.runner import BUILD, SIMULATORS, options, simulate
from tb.lib.stall_patterns import STALL_PAIRS, STALLS
from tb.lib.stream import Monitor, Sink, Source
from tb.lib.timing import documented_latency
from tb.memsys.faulty_memory import WRITE_FAULTS, BusFault, FaultyMemory
from tb.memsys.memory_bench import ModelAtPort
from tb.memsys.test_third_party_memory import attach, stall

MODULE = "tb.memsys.test_write_dma"
STREAMS = ("i", "i_hit", "i_sum", "o_done")
SMALL = {"memory.outstanding": 4, "memory.burst_beats": 8, "memory.length_bits": 4, "memory.timeout_bits": 10}
BASE = 0x3_0000_2000
COLUMNS, ROWS, CLUSTERS = 64, 16, 2
# Until late answers have come.
ATTEMPTS = 40


class Writes(wiring.Component):
    """The DMA at the port."""

    def __init__(self, *, config):
        self.port, self.dma = MainMemoryPort(config=config, tag=0), WriteDma(config=config)
        members = self.dma.signature.members
        super().__init__({**{name: members[name] for name in STREAMS}, "axi": Out(AxiSignature(config=config)),
                          "window": In(MemoryFormats(config).window)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.port, m.submodules.dma = port, dma = self.port, self.dma
        for given, mine in ((self.i, dma.i), (self.i_hit, dma.i_hit), (self.i_sum, dma.i_sum)):
            wiring.connect(m, wiring.flipped(given), mine)
        wiring.connect(m, dma.o_done, wiring.flipped(self.o_done))
        wiring.connect(m, dma.o_request, port.i_write)
        wiring.connect(m, dma.o_data, port.i_write_data)
        wiring.connect(m, port.o_written, dma.i_written)
        wiring.connect(m, port.axi, wiring.flipped(self.axi))
        m.d.comb += port.write_window.eq(self.window)
        return m


def drawn_hits(image, seed):
    """Any hits, a third of the rays without."""
    draw, rays = np.random.default_rng(seed), len(image["hits"])
    patch = np.where(draw.random(rays) < 0.3, -1, draw.integers(0, len(image["patches"]), rays))
    highest = {"inverse": 1 << 24, "u": 256, "v": 256}
    return FixedHits(patch=patch, **{
        name: np.where(patch >= 0, draw.integers(1, high, rays), 0) for name, high in highest.items()})


class Bench:
    """What gives hits and sums, and a memory with an image."""

    def __init__(self, dut, *, source="none", model=True, **memory):
        self.dut, self.config, self.seed = dut, config_of(options()["changes"]), options()["seed"]
        members = WriteDma(config=self.config).signature.members
        self.shapes = {name: members[name].signature.members["payload"].shape for name in STREAMS}
        self.data = Path(options()["image"]).read_bytes()
        self.image = from_bytes(self.data)
        window = MemoryFormats(self.config).window
        first, end = (BASE + self.image.offsets["hits"], BASE + len(self.data))
        dut.window.value = pack(window, {"base": first, "limit": end})
        self.command = Source(dut, "i")
        self.sources = {name: Source(dut, name, stalls=STALLS[source](self.seed + k))
                        for k, name in enumerate(("i_hit", "i_sum"))}
        self.done = Sink(dut, "o_done")
        self.memory = self.port = None
        if model:
            self.memory = FaultyMemory(self.config, self.data, base=BASE, seed=self.seed, **memory)
            self.port = ModelAtPort(dut, self.memory)

    def hits(self, hits, section):
        """Items for a section, as read-out gives them."""
        rays = [(row, column) for row in range(section.first_row, section.end_row)
                for column in range(section.first_column, section.end_column)]
        items = []
        for row, column in rays:
            ray = row * COLUMNS + column
            hit = {name: int(getattr(hits, name)[ray]) for name in ("inverse", "patch", "u", "v")}
            items.append({"column": column, "row": row, "hit": hit if hit["inverse"] else dict.fromkeys(hit, 0),
                          "last": (row, column) == rays[-1]})
        return items

    def sums(self, hits):
        """Items as the collector gives them, and the weights of all rays."""
        weights = np.repeat(self.image["rows"]["weight"].astype(np.int64), COLUMNS)
        sums = collect(hits.patch, weights, len(self.image["patches"]))
        return [{"patch": patch, "sum": int(value), "last": patch == len(sums) - 1}
                for patch, value in enumerate(sums)], int(weights.sum())

    async def write(self, kind, items, *, section=None, total=0, columns=COLUMNS, count=None):
        """The fault with which a command ends."""
        self.done.items.clear()
        region = kind.name.lower()
        section = section or Sector(0, 0, 0, 0)
        address = BASE + self.image.offsets[region]
        command = {"kind": kind.value, "address": address, "count": len(self.image[region]) if count is None else count,
                   "columns": columns, "total": total, "section": {
                       name: getattr(section, name) for name in ("first_column", "end_column", "first_row", "end_row")}}
        await self.command.send([pack(self.shapes["i"], command)])
        name = "i_hit" if kind is ResultKind.HITS else "i_sum"
        await self.sources[name].send([pack(self.shapes[name], item) for item in items])
        while not self.done.items:
            await RisingEdge(self.dut.clk)
        found = unpack(self.shapes["o_done"], self.done.items[0])
        assert found["address"] == address
        return Fault(found["code"])

    async def write_hits(self, hits, section):
        return await self.write(ResultKind.HITS, self.hits(hits, section), section=section)

    async def write_sums(self, hits):
        items, total = self.sums(hits)
        return await self.write(ResultKind.SUMS, items, total=total)

    def written(self, hits, sections, *, sums=False):
        """The image when hits of these sections have been written."""
        before, after = self.image, self.image.with_results(hits)
        mask = np.zeros((ROWS, COLUMNS), dtype=bool)
        for section in sections:
            mask[section.first_row:section.end_row, section.first_column:section.end_column] = True
        regions = {**before.regions, "hits": np.where(mask.reshape(-1), after["hits"], before["hits"])}
        return type(before)({**regions, "sums": after["sums"] if sums else before["sums"]}).to_bytes()

    def compare(self, expected, found=None, *, or_before=False):
        """Byte by byte; ``or_before``: where something has gone wrong, a byte may be as it was."""
        found = bytes(self.memory.data if found is None else found)
        different = [at for at, (a, b) in enumerate(zip(found, expected, strict=True))
                     if a != b and not (or_before and a == self.data[at])]
        assert not different, f"{len(different)} bytes are others, the first one at {different[0]}"

    def stop(self):
        if self.port:
            self.port.stop()
        self.done.stop()


@cocotb.test()
async def a_whole_image(dut):
    """Section by section and all sums: golden's image, byte by byte."""
    await start(dut, cycles=60_000)
    bench = Bench(dut, latency=9, spread=5)
    await RisingEdge(dut.clk)
    assert_known(dut, STREAMS)
    hits = drawn_hits(bench.image, bench.seed)
    for section in bench.image.sections():
        assert await bench.write_hits(hits, section) is Fault.NONE
    assert await bench.write_sums(hits) is Fault.NONE
    bench.compare(bench.image.with_results(hits).to_bytes())
    bench.stop()


@cocotb.test()
async def every_pair_of_stalls(dut):
    """Sections of any size; of what gives hits and of the memory."""
    await start(dut, cycles=100_000)
    draw = np.random.default_rng(options()["seed"])
    for number, (source, stalls) in enumerate(STALL_PAIRS):
        bench = Bench(dut, source=source, latency=3, spread=9, stalls={"aw": stalls, "w": stalls, "b": "random"})
        hits = drawn_hits(bench.image, number)
        columns, rows = (np.sort(draw.choice(size + 1, 2, replace=False)) for size in (12, 4))
        column, row = draw.integers(0, COLUMNS - 11), draw.integers(0, ROWS - 3)
        section = Sector(*(int(value) for value in (*(column + columns), *(row + rows))))
        assert await bench.write_hits(hits, section) is Fault.NONE
        if number % 5 == 3:
            assert await bench.write_sums(hits) is Fault.NONE
        bench.compare(bench.written(hits, [section], sums=number % 5 == 3))
        bench.stop()


@cocotb.test()
async def what_has_no_record(dut):
    """Ends with a fault; nothing is written but some of what was right before it; then all is well again."""
    await start(dut, cycles=100_000)
    seed = options()["seed"]
    outside, part = Sector(4, 12, ROWS - 2, ROWS + 1), Sector(4, 12, 2, 5)
    for name, section, change, rows in (
            ("rows beyond the last one", outside, None, 2), ("too wide", Sector(8, COLUMNS + 1, 2, 5), None, 0),
            ("no column", Sector(8, 8, 2, 5), "one", 0), ("no row", Sector(8, 9, 5, 5), "one", 0),
            ("too few", part, "short", 0), ("too many", part, "long", 3), ("another order", part, "swapped", 0),
            ("another row", part, "rows", 0)):
        bench = Bench(dut, latency=4)
        hits = drawn_hits(bench.image, seed)
        items = bench.hits(hits, section) if section is not outside else bench.hits(
            FixedHits(**{field: np.tile(getattr(hits, field), 2) for field in ("inverse", "patch", "u", "v")}), section)
        right = [Sector(section.first_column, section.end_column, section.first_row, section.first_row + rows)]
        if change == "one":
            items = [{"column": 8, "row": 2, "hit": dict.fromkeys(("inverse", "patch", "u", "v"), 0), "last": True}]
        elif change == "short":
            items, right = [*items[:9], {**items[9], "last": True}], [Sector(4, 12, 2, 3), Sector(4, 6, 3, 4)]
        elif change == "long":
            items = [*items[:-1], {**items[-1], "last": False}, *items[:3], {**items[0], "last": True}]
        elif change == "swapped":
            items[3], items[4], right = items[4], items[3], [Sector(4, 7, 2, 3)]
        elif change == "rows":
            # Of the same column.
            items[1], items[9], right = items[9], items[1], [Sector(4, 5, 2, 3)]
        assert await bench.write(ResultKind.HITS, items, section=section) is Fault.NO_RECORD, name
        bench.compare(bench.written(hits, right), or_before=True)
        bench.memory.data[:] = bench.data
        assert await bench.write_hits(hits, part) is Fault.NONE, name
        bench.compare(bench.written(hits, [part]))
        bench.stop()
    for name, change in (("too few", "short"), ("too many", "long"), ("another patch", "other"), ("no record", None),
                         ("another order", "swapped"), ("overflow", "overflow")):
        bench = Bench(dut, latency=4)
        hits = drawn_hits(bench.image, seed)
        items, total = bench.sums(hits)
        right = {"short": 20, "long": len(items) - 1, "other": 7, "swapped": 7, "overflow": 7, None: 0}[change]
        last = {**items[7], "last": True}
        given = {"short": [*items[:20], {**items[20], "last": True}], None: [last],
                 "long": [*items[:-1], {**items[-1], "last": False}, last],
                 "other": [*items[:7], *items[8:]], "swapped": [*items[:7], items[8], items[7], *items[9:]],
                 "overflow": [*items[:7], {**items[7], "overflow": 1}, *items[8:]]}[change]
        count = 1 if change is None else None
        assert await bench.write(ResultKind.SUMS, given, total=total, count=count) is (
            Fault.OVERFLOW if change == "overflow" else Fault.NO_RECORD), name
        after = bench.image.with_results(hits)["sums"].copy()
        after[right:] = bench.image["sums"][right:]
        bench.compare(type(bench.image)({**bench.image.regions, "sums": after}).to_bytes(), or_before=True)
        assert await bench.write_sums(hits) is Fault.NONE, name
        bench.compare(bench.written(hits, [], sums=True))
        bench.stop()


@cocotb.test()
async def errors_of_memory(dut):
    """An answer that is an error, and an address that is not the machine's."""
    await start(dut, cycles=40_000)
    section = Sector(0, 16, 0, 3)
    bench = Bench(dut)
    wrong = BASE + bench.image.offsets["hits"] + COLUMNS * 16 + 64
    bench.stop()
    bench = Bench(dut, fails=lambda address: address == wrong)
    hits = drawn_hits(bench.image, 3)
    assert await bench.write_hits(hits, section) is Fault.WRITE_REPLY
    assert await bench.write_hits(hits, Sector(0, 16, 2, 4)) is Fault.NONE
    bench.stop()
    bench = Bench(dut)
    window = MemoryFormats(bench.config).window
    dut.window.value = pack(window, {"base": wrong - 64, "limit": BASE + len(bench.data)})
    assert await bench.write_hits(hits, section) is Fault.WRITE_REPLY
    bench.compare(bench.written(hits, [Sector(0, 16, 1, 3)]), or_before=True)
    bench.stop()


@cocotb.test()
async def faults_of_the_bus(dut):
    """Results that memory answers wrongly end with a fault, or are right; so are the next ones, at once."""
    await start(dut, cycles=300_000)
    draw, bench = np.random.default_rng(options()["seed"]), Bench(dut, latency=4, spread=5)
    section = Sector(2, 40, 3, 6)
    for kind in WRITE_FAULTS:
        bench.memory.data[:], hits = bench.data, drawn_hits(bench.image, len(kind))
        # Only the first burst is alone.
        burst = 0 if kind == "answer before the data" else int(draw.integers(5))
        bench.memory.arm(BusFault(kind=kind, burst=burst, beat=0))
        code = await bench.write_hits(hits, section)
        assert bench.memory.struck, kind
        assert code is (Fault.NONE if kind in ("unexpected answer", "answer again") else Fault.WRITE_REPLY), kind
        bench.compare(bench.written(hits, [section]), or_before=True)
        for _ in range(ATTEMPTS):
            if await bench.write_hits(hits, section) is Fault.NONE:
                break
            bench.compare(bench.written(hits, [section]), or_before=True)
        else:
            assert bench.memory.lost, kind
            bench.stop()
            await reset(dut)
            bench = Bench(dut, latency=4, spread=5)
            assert await bench.write_hits(hits, section) is Fault.NONE
        bench.compare(bench.written(hits, [section]))
    bench.stop()


@cocotb.test()
async def reset_in_flight(dut):
    """What comes after it is right."""
    await start(dut, cycles=40_000)
    section = Sector(3, 20, 1, 4)
    for cycles in (5, 22, 40, 77):
        bench = Bench(dut, latency=9)
        hits = drawn_hits(bench.image, cycles)
        task = cocotb.start_soon(bench.write_hits(hits, Sector(0, COLUMNS, 0, ROWS)))
        await ClockCycles(dut.clk, cycles)
        task.cancel()
        bench.stop()
        dut.i__valid.value = dut.i_hit__valid.value = 0
        await reset(dut)
        bench = Bench(dut)
        assert await bench.write_hits(hits, section) is Fault.NONE
        bench.compare(bench.written(hits, [section]))
        bench.stop()


@cocotb.test()
async def a_word_per_cycle(dut):
    """Also from row to row; the first address comes after the latency."""
    await start(dut, cycles=40_000)
    bench = Bench(dut, latency=3)
    hits, section = drawn_hits(bench.image, 1), Sector(5, 25, 2, 8)
    monitors = {name: Monitor(dut, name) for name in ("i", "i_hit", "i_sum")}
    first_cycle = cocotb.start_soon(_first_cycle(dut))
    assert await bench.write_hits(hits, section) is Fault.NONE
    latency = documented_latency(WriteDma, bench.config, first_row=section.first_row)
    assert await first_cycle - monitors["i"].cycles[0] == latency + Writes(config=bench.config).port.latency
    assert np.all(np.diff(monitors["i_hit"].cycles) == 2)
    assert await bench.write_sums(hits) is Fault.NONE
    # Half a beat may wait for the other one, before memory takes the first one.
    assert np.all(np.diff(monitors["i_sum"].cycles)[1:] == 1)
    bench.stop()


async def _first_cycle(dut):
    """In which an address is valid."""
    while not int(dut.axi__awvalid.value):
        await RisingEdge(dut.clk)
    return round(get_sim_time("ns") / PERIOD)


@cocotb.test()
async def at_the_memory_of_others(dut):
    """Of cocotbext-axi, with its own stalls."""
    from cocotbext.axi import AddressSpace, MemoryRegion

    await start(dut, cycles=60_000)
    data = Path(options()["image"]).read_bytes()
    region, space = MemoryRegion(len(data)), AddressSpace()
    space.register_region(region, BASE)
    await region.write(0, data)
    channels = attach(dut, space)
    await reset(dut)
    stall(channels, ("random", "bursts"), options()["seed"])
    bench = Bench(dut, source="random", model=False)
    hits, sections = drawn_hits(bench.image, 9), [Sector(3, 30, 2, 6), Sector(40, 50, 8, 15)]
    for section in sections:
        assert await bench.write_hits(hits, section) is Fault.NONE
    assert await bench.write_sums(hits) is Fault.NONE
    bench.compare(bench.written(hits, sections, sums=True), await region.read(0, len(data)))
    bench.stop()


ALL = ("a_whole_image", "every_pair_of_stalls", "what_has_no_record", "errors_of_memory", "faults_of_the_bus",
       "reset_in_flight", "a_word_per_cycle", "at_the_memory_of_others")


@pytest.fixture(scope="module")
def image():
    """A small scene, with weights and nothing written."""
    made = case("lobby", rays=(COLUMNS, ROWS))
    plan = schedule(made.record, made.geometry, made.shelling.table, CONFIG, clusters=CLUSTERS, ratio=16, capacity=24,
                    topology="mesh")
    weights = Hemisphere(COLUMNS, ROWS).polar_weights
    data = machine_image(made.record, made.geometry, made.shelling.table, CONFIG, plan, weights=weights).to_bytes()
    path = (BUILD / "vectors" / "write_dma.bin").resolve()
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
    return path


def run(name, image, changes, simulator, tests=ALL):
    changes = {**SMALL, **changes}
    config = config_of(changes)
    dut = Writes(config=config)
    simulate(dut, MODULE, tests, simulator=simulator, name=name, changes=changes, image=str(image))


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_write_dma(image, simulator):
    run(f"write_dma-{simulator}", image, {}, simulator)


@pytest.mark.nightly
def test_wide_beats(image):
    run("write_dma-wide", image, {"memory.data_bits": 128}, "icarus")
