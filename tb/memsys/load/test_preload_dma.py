import random
from itertools import pairwise
from pathlib import Path

import cocotb
import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from cocotb.triggers import ClockCycles, RisingEdge

from golden.base.errors import InputError
from golden.engine.memory_map import ENTRY, EVERY_CLUSTER, HEADER, NONE, REGIONS, MemoryImage, from_bytes, phase_image
from golden.engine.schedule.phase import schedule
from hw.lib.payload import pack, unpack
from hw.memsys.load.image_header import TABLES
from hw.memsys.load.image_layout import PATCH_WORDS, RegionNumber
from hw.memsys.load.patch_extents import PatchExtents
from hw.memsys.load.preload_dma import PreloadDma
from hw.memsys.port.axi_signature import AxiSignature
from hw.memsys.port.fault import Fault
from hw.memsys.port.main_memory_port import MainMemoryPort
from hw.memsys.port.memory_formats import MemoryFormats
from tb.golden.engine.schedule.scenes import CONFIG, case
from tb.lib.clocking import reset, start
from tb.lib.configurations import config_of
from tb.lib.no_x import assert_known
from tb.lib.runner import BUILD, SLOW_IN_ICARUS, options, simulate
from tb.lib.scoreboard import check
from tb.lib.stall_patterns import STALLS, stall_pairs
from tb.lib.stream import Monitor, Sink, Source
from tb.lib.timing import documented_latency
from tb.memsys.faulty_memory import READ_FAULTS, BusFault, FaultyMemory
from tb.memsys.memory_bench import ModelAtPort

STREAMS = ("i", "o", "o_done")
SMALL = {"memory.outstanding": 8, "memory.burst_beats": 8, "memory.length_bits": 5, "memory.timeout_bits": 10}
BASE = 0x7_0000_1000
# Until late beats have come.
ATTEMPTS = 80
# Patches whose ids are read at once.
GROUP = 1 << PatchExtents.index_bits
OWN = ("clusters", "subshells", "residents", "patches")
NUMBER = {region.name: k for k, region in enumerate(REGIONS)}


class Preload(wiring.Component):
    """The DMA at the port."""

    def __init__(self, *, config):
        self.port, self.dma = MainMemoryPort(config=config, tag=0), PreloadDma(config=config)
        members = self.dma.signature.members
        super().__init__({**{name: members[name] for name in (*STREAMS, *TABLES)},
                          "axi": Out(AxiSignature(config=config)), "window": In(MemoryFormats(config).window)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.port, m.submodules.dma = port, dma = self.port, self.dma
        wiring.connect(m, wiring.flipped(self.i), dma.i)
        wiring.connect(m, dma.o, wiring.flipped(self.o))
        wiring.connect(m, dma.o_done, wiring.flipped(self.o_done))
        wiring.connect(m, dma.o_request, port.i_read)
        wiring.connect(m, port.o_read, dma.i_reply)
        wiring.connect(m, port.axi, wiring.flipped(self.axi))
        m.d.comb += [port.read_window.eq(self.window), *(getattr(self, name).eq(getattr(dma, name)) for name in TABLES)]
        return m


def words(image, region, cluster):
    """What must come of a region: (record, word, data)."""
    array = image[region.name]
    if region.name == "clusters":
        array = array[cluster:cluster + 1]
    elif region.name in ("subshells", "residents"):
        first = "first_subshell" if region.name == "subshells" else "first_resident"
        begin = int(image["clusters"][cluster][first])
        array = array[begin:begin + int(image["clusters"][cluster][region.name])]
    elif region.name == "patches":
        array = array[image.residents(cluster)]
    size = region.dtype.itemsize
    data = np.frombuffer(array.tobytes(), dtype="<u4" if size == 4 else "<u8").reshape(len(array), -(-size // 8))
    data = data[:, :PATCH_WORDS] if region.name == "patches" else data
    return [{"region": NUMBER[region.name], "record": record, "word": word, "data": int(value)}
            for record, row in enumerate(data) for word, value in enumerate(row)]


class Bench:
    """The DMA's clients, and a memory with an image."""

    def __init__(self, dut, *, sink="none", data=None, **memory):
        self.dut, self.config, seed = dut, config_of(options()["changes"]), options()["seed"]
        members = PreloadDma(config=self.config).signature.members
        self.shapes = {name: members[name].signature.members["payload"].shape for name in STREAMS}
        self.data = Path(options()["image"]).read_bytes() if data is None else data
        self.model = FaultyMemory(self.config, self.data, base=BASE, seed=seed, **memory)
        self.port = ModelAtPort(dut, self.model)
        window = MemoryFormats(self.config).window
        dut.window.value = pack(window, {"base": BASE, "limit": BASE + len(self.data)})
        self.command = Source(dut, "i")
        self.words, self.done = Sink(dut, "o", stalls=STALLS[sink](seed)), Sink(dut, "o_done")

    async def load(self, names, cluster=0, image=BASE):
        """The fault with which a command ends."""
        self.words.items.clear()
        self.words.cycles.clear()
        self.done.items.clear()
        mask = sum(1 << NUMBER[name] for name in names)
        await self.command.send([pack(self.shapes["i"], {"image": image, "cluster": cluster, "regions": mask})])
        while not self.done.items:
            await RisingEdge(self.dut.clk)
        found = unpack(self.shapes["o_done"], self.done.items[0])
        return Fault(found["code"]), found["address"]

    def compare(self, names, cluster):
        image, shape = from_bytes(self.data), self.shapes["o"]
        expected = [word for region in sorted(
            (region for region in REGIONS if region.name in names), key=lambda region: region.name != "clusters")
            for word in words(image, region, cluster)]
        check(shape, self.words.items, [pack(shape, word) for word in expected], what="o")

    def stop(self):
        self.port.stop()
        self.words.stop()
        self.done.stop()


@cocotb.test()
async def the_whole_image(dut):
    """All regions, for each cluster what is its own."""
    await start(dut, cycles=100_000)
    names = [region.name for region in REGIONS]
    bench = Bench(dut, latency=10, spread=10, shuffles=True)
    await RisingEdge(dut.clk)
    assert_known(dut, STREAMS)
    for cluster in range(options()["clusters"]):
        chosen = names if cluster == 0 else OWN
        assert (await bench.load(chosen, cluster))[0] is Fault.NONE
        bench.compare(chosen, cluster)
    image = from_bytes(bench.data)
    for name in TABLES:
        found_at = int(getattr(dut, name).value)
        width = bench.config.memory.address_bits
        assert found_at & (1 << width) - 1 == BASE + image.offsets[name]
        assert found_at >> width == len(image[name])
    bench.stop()


@cocotb.test()
async def copies_of_all_clusters(dut):
    """An image where each cluster has a copy: all regions at once, with the residents of cluster 0."""
    await start(dut, cycles=100_000)
    image = from_bytes(Path(options()["image"]).read_bytes())
    count = 37
    clusters, residence = image["clusters"].copy(), image["residence"].copy()
    residence["cluster"], residence["address"] = NONE, NONE
    residence["cluster"][:count], residence["address"][:count] = EVERY_CLUSTER, np.arange(count)
    clusters["residents"], clusters["first_resident"] = [count, *[0] * (len(clusters) - 1)], 0
    clusters["first_subshell"] = clusters["subshells"] = 0
    residents = np.zeros(count, image["residents"].dtype)
    residents["patch"] = np.arange(count)
    data = MemoryImage({**image.regions, "clusters": clusters, "residence": residence, "residents": residents,
                        "subshells": image["subshells"][:0]}).to_bytes()
    names = [region.name for region in REGIONS]
    bench = Bench(dut, data=data, latency=10, spread=10, shuffles=True)
    assert (await bench.load(names))[0] is Fault.NONE
    bench.compare(names, 0)
    assert (await bench.load(OWN, 1))[0] is Fault.NONE
    bench.compare(OWN, 1)
    assert len(bench.words.items) == len(words(from_bytes(data), REGIONS[NUMBER["clusters"]], 1))
    bench.stop()


@cocotb.test()
async def every_pair_of_stalls(dut):
    """Of what takes the words and of the memory."""
    await start(dut, cycles=200_000)
    for number, (sink, memory) in enumerate(stall_pairs()):
        bench = Bench(dut, sink=sink, latency=3, spread=9, shuffles=True, stalls={"ar": memory, "r": memory})
        cluster = number % options()["clusters"]
        names = (("shells", "subshells"), ("residents",), ("patches",))[number % 3]
        assert (await bench.load(names, cluster))[0] is Fault.NONE
        bench.compare(names, cluster)
        bench.stop()


def broken_images(data):
    """Images with one thing wrong each: name, bytes, what is loaded, the fault's code and region.

    `test_image_header.py` and `test_table_check.py` have the limits of each rule.
    """
    entries = HEADER.dtype.itemsize

    def with_value(offset, value, kind="<u4"):
        changed = bytearray(data)
        array = np.array([value], dtype=kind).tobytes()
        changed[offset:offset + len(array)] = array
        return bytes(changed)

    def entry(name, field):
        return entries + NUMBER[name] * ENTRY.dtype.itemsize + ENTRY.dtype.fields[field][1]

    def field(region, record, name):
        layout = REGIONS[NUMBER[region]].dtype
        return offsets[region] + record * layout.itemsize + layout.fields[name][1]

    image = from_bytes(data)
    offsets = image.offsets
    cluster = image["clusters"][0]
    last = len(image["cells"]) - 1
    return [
        ("magic", with_value(0, 1), "cells", Fault.IMAGE, None),
        ("version", with_value(4, 7), "cells", Fault.IMAGE, None),
        ("far beyond", with_value(entry("rows", "offset"), 1 << 60, "<u8"), "cells", Fault.REGION, None),
        ("very long", with_value(entry("cells", "count"), 1 << 32, "<u8"), "cells", Fault.REGION, None),
        ("cells.pointer", with_value(field("cells", last, "pointer"), 1 << 31), "cells", Fault.POINTER, "cells"),
        ("patch_lists", with_value(field("patch_lists", 7, "patch"), len(image["patches"])), "patch_lists",
         Fault.POINTER, "patch_lists"),
        ("residents", with_value(field("residents", int(cluster["first_resident"]), "patch"), 1 << 20), "patches",
         Fault.POINTER, "residents"),
        ("patches.id", with_value(field("patches", int(image.residents(0)[3]), "id"), len(image["patches"])), "patches",
         Fault.POINTER, "patches"),
        ("subshells", with_value(field("subshells", int(cluster["first_subshell"]), "patch"), 1 << 20), "subshells",
         Fault.POINTER, "subshells"),
        ("patches.kind", with_value(field("patches", int(image.residents(0)[17]), "kind"), 1, "u1"), "patches",
         Fault.SIZE, "patches"),
        ("residence.cluster", with_value(field("residence", 5, "cluster"), len(image["clusters"])), "residence",
         Fault.POINTER, "residence"),
        ("residence.cluster below", with_value(field("residence", 5, "cluster"), -3, "<i4"), "residence", Fault.POINTER,
         "residence"),
        ("clusters.subshells", with_value(field("clusters", 0, "subshells"), 1 << 30), "subshells", Fault.POINTER,
         "clusters"),
        ("clusters.first_resident", with_value(field("clusters", 0, "first_resident"), 0xFFFF_FFFF), "patches",
         Fault.POINTER, "clusters"),
        ("shells.rows", with_value(field("shells", 1, "rows"), 1 << 30), "shells", Fault.POINTER, "shells"),
        ("cell_grid.shape", with_value(field("cell_grid", 0, "shape"), 1 << 10), "cell_grid", Fault.SIZE, "cell_grid"),
        ("shells.first_ray", with_value(field("shells", 2, "first_ray"), (1 << 20) - 1), "shells", Fault.SIZE,
         "shells"),
        ("shells.first_column", with_value(field("shells", 1, "first_column"), 1 << 30), "shells", Fault.POINTER,
         "shells")]


@cocotb.test()
async def malformed_tables(dut):
    """Each ends in its code; nothing of the record comes out; the next request is answered right."""
    await start(dut, cycles=200_000)
    good = Path(options()["image"]).read_bytes()
    offsets = from_bytes(good).offsets
    for name, data, loaded, code, region in broken_images(good):
        with pytest.raises(InputError):
            from_bytes(data)
        bench = Bench(dut, data=data, latency=5)
        address = BASE if region is None else BASE + offsets[region]
        assert await bench.load([loaded]) == (code, address), name
        for item in bench.words.items:
            word = unpack(bench.shapes["o"], item)
            assert word in words(from_bytes(good), REGIONS[NUMBER[loaded]], 0), name
        bench.stop()
        bench = Bench(dut, latency=5)
        assert (await bench.load(["rows"]))[0] is Fault.NONE, name
        bench.compare(["rows"], 0)
        bench.stop()
    bench = Bench(dut)
    assert await bench.load(["rows"], cluster=999) == (Fault.NONE, BASE + offsets["rows"])
    assert (await bench.load(["residents"], cluster=options()["clusters"]))[0] is Fault.POINTER
    assert (await bench.load(["rows"], image=BASE - 4096))[0] is Fault.READ_REPLY
    bench.stop()
    # A record behind the table of clusters is no cluster's, however good it is.
    fewer, last = bytearray(good), options()["clusters"] - 1
    fewer[HEADER.dtype.itemsize + NUMBER["clusters"] * ENTRY.dtype.itemsize + ENTRY.dtype.fields["count"][1]] = last
    bench = Bench(dut, data=bytes(fewer))
    assert (await bench.load(["residents"], cluster=last))[0] is Fault.POINTER
    bench.stop()
    bench = Bench(dut, fails=lambda address: address == BASE + offsets["cells"] + 768, latency=4)
    assert await bench.load(["cells"]) == (Fault.READ_REPLY, BASE + offsets["cells"])
    assert len(bench.words.items) < 100
    bench.stop()


@cocotb.test()
async def faults_of_the_bus(dut):
    """Loads of tables that memory answers wrongly end with a fault, or are right; so are the next ones, at once."""
    await start(dut, cycles=300_000)
    draw, bench = random.Random(options()["seed"]), Bench(dut, latency=4, spread=5, shuffles=True)
    names = ("clusters", "cells", "patches")
    for kind in READ_FAULTS:
        burst, beat = draw.randrange(12), draw.randrange(8)
        bench.model.arm(BusFault(kind=kind, burst=burst, beat=beat))
        code, _ = await bench.load(names)
        if not bench.model.struck:
            # Patches of one beat each cannot have it.
            bench.model.arm(BusFault(kind=kind, burst=0, beat=beat))
            code, _ = await bench.load(names)
        assert bench.model.struck, kind
        harmless = kind in ("unexpected beat", "last beat again")
        assert code is (Fault.NONE if harmless else Fault.READ_REPLY), kind
        if harmless:
            bench.compare(names, 0)
        # What will never end is known to the memory alone.
        for _ in range(3 if bench.model.lost else ATTEMPTS):
            if (await bench.load(names))[0] is Fault.NONE:
                break
        else:
            assert bench.model.lost, kind
            bench.stop()
            await reset(dut)
            bench = Bench(dut, latency=4, spread=5, shuffles=True)
            assert (await bench.load(names))[0] is Fault.NONE
        bench.compare(names, 0)
        assert bench.model.data == bench.data
    bench.stop()


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing of before comes out after it."""
    await start(dut, cycles=50_000)
    for cycles in (3, 60, 300, 420, 480, 700):
        bench = Bench(dut, latency=9)
        task = cocotb.start_soon(bench.load([region.name for region in REGIONS]))
        await ClockCycles(dut.clk, cycles)
        task.cancel()
        bench.stop()
        dut.i__valid.value = 0
        await reset(dut)
        bench = Bench(dut)
        assert (await bench.load(OWN))[0] is Fault.NONE
        bench.compare(OWN, 0)
        bench.stop()


@cocotb.test()
async def a_word_per_cycle(dut):
    """Within a region, and with patches whose ids are read at once.

    A burst goes on when all of it has come. A region that begins within a burst's extent has a short one
    first, after which the next, longer one may be awaited.
    """
    await start(dut, cycles=50_000)
    bench = Bench(dut, latency=20)
    memory, offsets = bench.config.memory, from_bytes(bench.data).offsets
    burst_bytes = memory.burst_beats * memory.beat_bytes
    for name in "grid_columns", "cells", "patch_lists", "patches":
        assert (await bench.load([name]))[0] is Fault.NONE
        late = [k for k, (a, b) in enumerate(pairwise(bench.words.cycles), 1) if b - a != 1]
        if name == "patches":
            # The second patch of one beat each follows the first one's, which waits in the port, at a distance.
            assert late in ([], [PATCH_WORDS]), name
            continue
        before = (BASE + offsets[name]) % burst_bytes
        word_bytes = min(8, REGIONS[NUMBER[name]].dtype.itemsize)
        assert late in ([], *([[(burst_bytes - before) // word_bytes]] if before else [])), name
    bench.stop()


@cocotb.test()
async def groups_of_patches(dut):
    """More patches than ids are read at once: all come, in at most 8 cycles each, and under stalls; a wrong id ends the
    load.
    """
    await start(dut, cycles=200_000)
    # All clusters have the same residents in three groups.
    count, image = 2 * GROUP + 76, from_bytes(Path(options()["image"]).read_bytes())
    clusters, patches = image["clusters"].copy(), len(image["patches"])
    clusters["first_resident"], clusters["residents"] = 0, [count] * len(clusters)
    residents = np.zeros(count, image["residents"].dtype)
    residents["patch"] = np.arange(count) * 29 % patches
    image = MemoryImage({**image.regions, "clusters": clusters, "residents": residents})
    data, offset = image.to_bytes(), image.offsets["residents"]
    bench, commands = Bench(dut, data=data, latency=10), Monitor(dut, "i")
    assert (await bench.load(["patches"]))[0] is Fault.NONE
    cycles = bench.done.cycles[0] - commands.cycles[0]
    commands.stop()
    bench.compare(["patches"], 0)
    assert cycles <= 8 * count, f"{cycles / count:.2f} cycles per patch"
    bench.stop()
    bench = Bench(dut, sink="bursts", data=data, latency=3, spread=9, shuffles=True)
    assert (await bench.load(["patches"]))[0] is Fault.NONE
    bench.compare(["patches"], 0)
    bench.stop()
    # After the groups before the one with an id that no patch has.
    for wrong in GROUP - 1, GROUP, count - 1:
        changed, at = bytearray(data), offset + 4 * wrong
        changed[at:at + 4] = patches.to_bytes(4, "little")
        bench = Bench(dut, data=bytes(changed), latency=3)
        assert await bench.load(["patches"]) == (Fault.POINTER, BASE + offset)
        assert len(bench.words.items) == wrong // GROUP * GROUP * PATCH_WORDS
        bench.stop()


CLUSTERS = 2


@pytest.fixture(scope="module")
def image():
    """A small scene, and a resident set."""
    made = case("lobby")
    plan = schedule(made.record, made.geometry, made.shelling.table, CONFIG, clusters=CLUSTERS, ratio=16, capacity=24,
                    topology="mesh")
    data = phase_image([made.record], made.geometry, made.shelling.table, CONFIG, plan=plan).to_bytes()
    path = (BUILD / "vectors" / "preload_dma.bin").resolve()
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
    return path


def run(name, image, changes, simulator):
    changes = {**SMALL, **changes}
    config = config_of(changes)
    dut = Preload(config=config)
    assert dut.dma.latency == documented_latency(PreloadDma, config)
    simulate(dut, __name__, simulator=simulator, name=name, changes=changes, image=str(image), clusters=CLUSTERS)


@pytest.mark.parametrize("simulator", SLOW_IN_ICARUS)
def test_preload_dma(image, simulator):
    run(f"preload_dma-{simulator}", image, {}, simulator)


@pytest.mark.icarus
@pytest.mark.nightly
@pytest.mark.parametrize("bits", [128, 256, 512])
def test_wide_beats(image, bits):
    run(f"preload_dma-{bits}", image, {"memory.data_bits": bits}, "icarus")


def test_regions_are_those_of_the_image():
    assert [number.name.lower() for number in RegionNumber] == [region.name for region in REGIONS]
