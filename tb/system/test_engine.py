"""Whole frusta on the whole machine, driven by the host: hits and sums are brute force's."""

import random
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

import cocotb
import numpy as np
import pytest
from cocotb.triggers import ClockCycles

from golden.errors import InputError
from golden.memory_map import REGIONS, MemoryImage
from hw.control.load_control import ALL as ALL_REGIONS
from hw.host import LIVES, EngineError, Host
from hw.memsys.cache_policy import CachePolicy
from hw.registers.engine_registers import COUNTER_BITS, COUNTERS_BASE, ENGINE_REGISTERS
from hw.registers.error_code import ErrorCode
from hw.registers.register import addresses
from hw.simulator.machine_verilog import engine_verilog
from hw.simulator.register_error import RegisterError
from tb.axi.axi_protocol import AxiProtocol
from tb.axi.port_monitor import PortMonitor
from tb.lib.clocking import reset, start
from tb.lib.configurations import config_of
from tb.lib.runner import BUILD, options, simulate
from tb.lib.stall_patterns import STALLS
from tb.memsys.memory_bench import ModelAtPort
from tb.memsys.memory_model import MemoryModel
from tb.system.cocotb_port import CocotbPort
from tb.system.scenes import frusta, load, save
from tb.system.small_machine import BASE, LISTS, SMALL

MODULE = "tb.system.test_engine"


class Bench:
    """The engine, a memory and a host."""

    def __init__(self, dut, *, images=1, **memory):
        self.dut, self.given = dut, options()
        self.config = config_of(self.given["changes"])
        self.frusta = load(Path(self.given["folder"]))
        self.image_bytes = max(len(one.image.to_bytes()) for one in self.frusta)
        self._memory = {"data": bytes(images * self.image_bytes), "base": BASE, "seed": self.given["seed"], **memory}
        self.model = MemoryModel(self.config, **self._memory)
        self._at_port = ModelAtPort(dut, self.model)
        self.port = CocotbPort(dut, self.model)
        self.host = Host(self.port, self.config, base=BASE)

    def stop(self):
        """No memory."""
        self._at_port.stop()

    def restart(self):
        """An empty memory with nothing outstanding."""
        self.stop()
        self.model = self.port.memory = MemoryModel(self.config, **self._memory)
        self._at_port = ModelAtPort(self.dut, self.model)

    async def check(self, frustum, **loaded):
        """Loads and casts it; compares every byte that the machine writes."""
        await self.host.load(frustum.image, **loaded)
        cycles = await self.host.cast(timeout=self.given["cycles"])
        self.compare(await self.host.results(total=frustum.total), frustum)
        counters = await self.host.counters()
        self.dut._log.info("%d cycles, %s", cycles, counters)
        return counters

    @staticmethod
    def compare(image, frustum):
        different = image.hits().differences(frustum.hits)
        assert not len(different), (
            f"{len(different)} of {len(frustum.hits.patch)} rays differ, the first is {different[0]}: "
            f"{image['hits'][different[0]]} instead of {frustum.written['hits'][different[0]]}")
        wrong = np.flatnonzero(image["sums"]["sum"] != frustum.written["sums"]["sum"])
        assert not len(wrong), f"sums of patches {wrong.tolist()} differ"
        assert image["hits"].tobytes() == frustum.written["hits"].tobytes()


@cocotb.test()
async def whole_frusta(dut):
    """All frusta of a phase, one after the other."""
    bench = Bench(dut, latency=10, spread=6, shuffles=True)
    await start(dut, cycles=options()["cycles"])
    await bench.host.identify()
    for number, frustum in enumerate(bench.frusta):
        lives = tuple(LIVES) if number == 0 else ("rays", "frustum")
        counters = await bench.check(frustum, lives=lives)
        assert sum(one["intersection_won"] for one in counters) >= (frustum.hits.patch >= 0).sum()


@cocotb.test()
async def results_beside_the_next_frustum(dut):
    """Hits and sums of a frustum are written while the next one is cast; two images in memory."""
    bench = Bench(dut, images=2, latency=5, spread=20)
    await start(dut, cycles=options()["cycles"])
    host, image_bytes, beside = bench.host, bench.image_bytes, 0
    before = None
    for number, frustum in enumerate(bench.frusta):
        await host.load(frustum.image, lives=tuple(LIVES) if number == 0 else ("rays", "frustum"),
                        base=BASE + number % 2 * image_bytes)
        if number == 2:
            # The first image, and with it the scene, has been written over with the same one.
            assert bench.frusta[0].image["cells"].tobytes() == frustum.image["cells"].tobytes()
        await host.start()
        if before is not None:
            image = await host.results(total=before.total, earlier=True)
            beside += (await host.status())["casts"]
            bench.compare(image, before)
        await host.finish("casts", timeout=bench.given["cycles"])
        before = frustum
    bench.compare(await host.results(total=before.total), before)
    dut._log.info("%d of %d results were written beside a cast", beside, len(bench.frusta) - 1)


@cocotb.test()
async def form_factors_alone(dut):
    """Sums of several frusta add up; hits are not written."""
    bench = Bench(dut)
    await start(dut, cycles=options()["cycles"])
    host, total = bench.host, 0
    for number, frustum in enumerate(bench.frusta):
        await host.load(frustum.image, lives=tuple(LIVES) if number == 0 else ("rays", "frustum"))
        await host.cast()
        last = number == len(bench.frusta) - 1
        total += frustum.total
        image = await host.results(hits=False, sums=last, total=total)
        assert (image["hits"]["patch"] == -1).all()
    expected = sum(frustum.written["sums"]["sum"].astype(np.int64) for frustum in bench.frusta)
    assert (image["sums"]["sum"] == expected).all()


@cocotb.test()
async def all_policies(dut):
    """Of the caches; the scene is loaded anew with each."""
    bench = Bench(dut, latency=10)
    await start(dut, cycles=options()["cycles"])
    for policy in CachePolicy:
        for number, frustum in enumerate(bench.frusta):
            await bench.check(frustum, policy=policy, lives=("rays", "frustum") if number else tuple(LIVES))


async def fails(code, action):
    """An action must end in an error."""
    with pytest.raises(EngineError) as raised:
        await action
    error = raised.value
    assert error.code in (code if isinstance(code, tuple) else (code,)), f"{error} instead of {code}"
    return error


@cocotb.test()
async def what_goes_wrong(dut):
    """Commands, windows, memory and watchdog; after each the next frustum is right."""
    bad, silent = set(), set()
    bench = Bench(dut, images=9, fails=lambda address: address in bad)
    await start(dut, cycles=options()["cycles"])
    host, model, frustum = bench.host, bench.model, bench.frusta[0]
    image, data = frustum.image, frustum.image.to_bytes()
    model.silent = silent

    async def right():
        bad.clear()
        silent.clear()
        await host.write("watchdog", 1 << 20)
        await bench.check(frustum)

    async def loaded():
        await host.load(image)
        assert (await host.status())["loaded"]

    await fails(ErrorCode.NOT_LOADED, host.cast())
    await host.command("write")
    await fails(ErrorCode.COMMAND, host.finish("writes", timeout=1000))
    await right()
    for name in ("load", "cast", "write"):
        await host.start()
        await host.command(name)
        await fails(ErrorCode.COMMAND, host.finish("casts", timeout=100_000))
        bench.compare(await host.results(total=frustum.total), frustum)
    for at, code in ((0, ErrorCode.IMAGE), (4, ErrorCode.IMAGE), (16, ErrorCode.REGION),
                     (image.offsets["near_cells"] + 3, ErrorCode.POINTER)):
        broken = bytearray(data)
        broken[at] ^= 0x7F
        await loaded()
        await host.write_image(bytes(broken))
        await host.command("load")
        await fails(code, host.finish("loads", timeout=100_000))
        await fails(ErrorCode.NOT_LOADED, host.cast())
        await right()
    bad.add(BASE + image.offsets["cells"])
    error = await fails(ErrorCode.READ_REPLY, host.load(image))
    assert error.address == BASE + image.offsets["cells"]
    await right()
    await loaded()
    bad |= {BASE + image.offsets["patches"] + 64 * patch + 8 * word for patch in range(len(image["patches"]))
            for word in range(6)}
    await fails((ErrorCode.READ_REPLY, ErrorCode.PATH_BUS), host.cast())
    await right()
    bad.add(BASE + image.offsets["sums"])
    await fails(ErrorCode.WRITE_REPLY, host.results(total=frustum.total))
    await right()
    for what, code in (("loads", ErrorCode.READ_TIMEOUT), ("casts", (ErrorCode.READ_TIMEOUT, ErrorCode.PATH_BUS))):
        if what == "casts":
            await loaded()
        silent |= {"r"}
        action = host.load(image) if what == "loads" else host.cast()
        await fails(code, action)
        await right()
    silent |= {"b"}
    await fails(ErrorCode.WRITE_TIMEOUT, host.results(total=frustum.total))
    await right()
    await loaded()
    await host.write("watchdog", 300)
    await fails(ErrorCode.WATCHDOG, host.cast())
    assert not (await host.status())["loaded"]
    await right()
    # A section of more tiles than the ray memory has.
    broken = MemoryImage({**image.regions, "clusters": image["clusters"].copy(), "columns": np.zeros(
        64, image["columns"].dtype), "rows": np.zeros(64, image["rows"].dtype), "hits": np.zeros(
        4096, image["hits"].dtype), "frustum": image["frustum"].copy()})
    broken["frustum"]["columns"] = broken["frustum"]["rows"] = 64
    broken["clusters"]["first_column"] = broken["clusters"]["first_row"] = 0
    broken["clusters"]["end_column"] = broken["clusters"]["end_row"] = 64
    with pytest.raises(InputError, match="Tiles of a section must be at most 64"):
        await host.load(broken)
    await host.load(broken, check=False)
    await fails(ErrorCode.SECTION, host.cast())
    await right()
    await host.write("read_limit", BASE + 4096)
    await host.command("load")
    await fails((ErrorCode.READ_OUTSIDE, ErrorCode.READ_REPLY), host.finish("loads", timeout=100_000))
    await right()


@cocotb.test()
async def values_that_mean_nothing(dut):
    """In the registers: each ends in an error, or is as if it were another value."""
    bench = Bench(dut)
    await start(dut, cycles=options()["cycles"])
    host, frustum = bench.host, bench.frusta[0]
    await host.identify()
    for name in ("magic", "status", "error", "cycles", "patch_misses"):
        with pytest.raises(RegisterError):
            await host.write(name, 1)
    for address in (0x1000, 0x3FFC):
        with pytest.raises(RegisterError):
            await bench.port.read(address)
    await bench.check(frustum)
    await bench.port.write(addresses(ENGINE_REGISTERS)["command"], 0)
    await fails(ErrorCode.COMMAND, host.finish("loads", timeout=1000))
    for image in (BASE + 4, BASE + 8, BASE + (1 << 44) - 64, 0):
        await host.write("image", image)
        await host.command("load")
        await fails((ErrorCode.READ_OUTSIDE, ErrorCode.READ_REPLY, ErrorCode.IMAGE),
                    host.finish("loads", timeout=20_000))
    await bench.check(frustum)
    # Windows the wrong way round.
    await host.write("read_base", BASE + (1 << 20))
    await host.command("load")
    await fails((ErrorCode.READ_OUTSIDE, ErrorCode.READ_REPLY), host.finish("loads", timeout=20_000))
    await host.load(frustum.image)
    # All bits of the regions, and a policy that there is not.
    await host.write("regions", (1 << 17) - 1)
    await host.write("policy", 3)
    await host.command("load")
    await host.finish("loads", timeout=20_000)
    await host.cast()
    bench.compare(await host.results(total=frustum.total), frustum)
    assert await bench.port.read(COUNTERS_BASE + (63 << COUNTER_BITS + 2)) == 0
    await bench.check(frustum)


@cocotb.test()
async def a_moved_vertex_is_seen(dut):
    """The comparisons are not of what was there before."""
    bench = Bench(dut)
    await start(dut, cycles=options()["cycles"])
    frustum = bench.frusta[0]
    await bench.check(frustum)
    moved = MemoryImage({**frustum.image.regions, "patches": frustum.image["patches"].copy()})
    moved["patches"]["vertex"][:, 0] ^= 1 << 20
    await bench.host.load(moved)
    await bench.host.cast()
    image = await bench.host.results(total=frustum.total)
    assert len(image.hits().differences(frustum.hits)) > 20
    with pytest.raises(AssertionError, match="rays differ"):
        bench.compare(image, frustum)
    await bench.check(frustum)


@cocotb.test()
async def stops_in_flight(dut):
    """The host ends a load, a cast, and the writing of results, at any time; then all is right."""
    bench = Bench(dut, latency=8, spread=8, shuffles=True)
    await start(dut, cycles=options()["cycles"])
    host, frustum = bench.host, bench.frusta[0]
    await host.load(frustum.image)
    for cycles in (5, 200, 900):
        await host.command("load")
        await bench.port.wait(cycles)
        await host.stop()
        await bench.check(frustum)
        await host.start()
        await bench.port.wait(cycles)
        await host.stop()
        assert not (await host.status())["present"]
        await bench.check(frustum)
        await host.command("write")
        await bench.port.wait(cycles // 3)
        await host.stop()
        await bench.check(frustum)


@cocotb.test()
async def reset_in_flight(dut):
    """Machine and memory are reset together."""
    bench = Bench(dut, latency=8)
    await start(dut, cycles=options()["cycles"])
    for cycles in (50, 700, 1500, 3000):
        task = cocotb.start_soon(bench.check(bench.frusta[0]))
        await ClockCycles(dut.clk, cycles)
        task.cancel()
        bench.restart()
        await reset(dut)
        await bench.check(bench.frusta[0])


def run(name, scene, changes, tests, *, cell, clusters, cycles, corruptions=0, **frustum):
    changes = {**changes, "noc.columns": clusters}
    config = config_of(changes)
    folder = save(frusta(scene, config, cell=cell, **frustum), BUILD / "vectors" / f"engine-{name}")
    simulate(engine_verilog(config), MODULE, tests, name=f"engine-{name}", changes=changes,
             visible=("clk", "rst", "host__*", "axi__*"), folder=str(folder), cycles=cycles, corruptions=corruptions)


def third_party_memory(bench):
    """Puts a memory of cocotbext-axi in place of the model."""
    from cocotbext.axi import AxiBus, AxiRam

    dut = bench.dut
    bench.stop()
    PortMonitor(dut, "axi", AxiProtocol(bench.config))
    ram = AxiRam(AxiBus.from_prefix(dut, "axi", bus_separator="__"), dut.clk, dut.rst, size=1 << 16)
    for half in ram.write_if, ram.read_if:
        half.log.setLevel("WARNING")
    bench.port.memory = SimpleNamespace(base=0, data=ram.mem)
    bench.host = Host(bench.port, bench.config, base=0x4000)
    return ram


@cocotb.test()
async def third_parties(dut):
    """Registers and memory are both driven by others, cocotbext-axi's manager and RAM, with stalls."""
    bench = Bench(dut)
    ram = third_party_memory(bench)
    await start(dut, cycles=options()["cycles"])
    master, write, read = bench.port.master, ram.write_if, ram.read_if
    channels = (master.write_if.aw_channel, master.write_if.w_channel, master.write_if.b_channel,
                master.read_if.ar_channel, master.read_if.r_channel, write.aw_channel, write.w_channel,
                write.b_channel, read.ar_channel, read.r_channel)
    for number, regime in enumerate(STALLS):
        for k, channel in enumerate(channels):
            channel.set_pause_generator(STALLS[regime](10 * number + k))
        await bench.check(bench.frusta[number % len(bench.frusta)])


# Regions, and the most cycles that a frustum whose tables are wrong may take.
KINDS, TIMEOUT = tuple(region.name for region in REGIONS if region.life != "result"), 20_000


@cocotb.test()
async def corrupted_tables(dut):
    """Words of each table that are anything: a load or a cast ends all the same, with an error or without one; memory
    sees no access outside the windows; the next frustum is right.
    """
    bench = Bench(dut, latency=3, images=2)
    await start(dut, cycles=options()["cycles"])
    host, model, frustum = bench.host, bench.model, bench.frusta[0]
    draw, found = random.Random(options()["seed"]), Counter()
    data, offsets = frustum.image.to_bytes(), frustum.image.offsets
    await bench.check(frustum)
    for kind in KINDS:
        size = frustum.image[kind].nbytes
        for _ in range(options()["corruptions"] if size else 0):
            broken = bytearray(data)
            for _ in range(draw.choice((1, 1, 3))):
                at = offsets[kind] + draw.randrange(size // 4) * 4
                value = draw.choice((0, 1, 0x7FFFFFFF, 0xFFFFFFFF, 1 << draw.randrange(32), draw.getrandbits(32)))
                broken[at:at + 4] = value.to_bytes(4, "little")
            model.reads.clear()
            model.writes.clear()
            outcome = "unnoticed"
            try:
                await host.load(frustum.image, lives=())
            except EngineError as error:
                raise AssertionError("nothing was loaded") from error
            await host.write("watchdog", TIMEOUT)
            await host.write("regions", ALL_REGIONS)
            await host.write_image(bytes(broken))
            try:
                await host.command("load")
                await host.finish("loads", timeout=2 * TIMEOUT)
                await host.cast(timeout=2 * TIMEOUT)
                await host.results(total=frustum.total, timeout=2 * TIMEOUT)
            except EngineError as error:
                outcome = error.code.name
            found[kind, outcome] += 1
            for first, beats in model.reads:
                assert BASE <= first <= BASE + len(data) - 8 * beats, f"{kind}: a read at {first:#x}"
            for first, beats in model.writes:
                assert BASE + offsets["hits"] <= first <= BASE + len(data) - 8 * beats, f"{kind}: written {first:#x}"
        await bench.check(frustum)
    for (kind, outcome), count in sorted(found.items()):
        dut._log.info("%s: %s %d", kind, outcome, count)
    assert any(outcome != "unnoticed" for _, outcome in found)


QUICK = ("whole_frusta", "results_beside_the_next_frustum", "form_factors_alone", "all_policies", "what_goes_wrong",
         "values_that_mean_nothing", "a_moved_vertex_is_seen", "stops_in_flight", "reset_in_flight",
         "third_parties", "corrupted_tables")


@pytest.mark.sim
@pytest.mark.parametrize("clusters", [1, 2])
def test_cornell(clusters):
    given = {"clusters": clusters, "cell": 0.5, "cycles": 3_000_000}
    run(f"cornell-{clusters}", "cornell", SMALL, QUICK, points=(5, 1, 2), corruptions=2, **given)
    run(f"cornell-screen-{clusters}", "cornell", SMALL, ("whole_frusta",), pixels=(30, 20), **given)


@pytest.mark.nightly
def test_subshell_lists():
    run("cornell-lists", "cornell", SMALL | LISTS, QUICK, points=(5, 1, 2), corruptions=2, clusters=2, cell=0.5,
        cycles=3_000_000)


@pytest.mark.nightly
@pytest.mark.parametrize("clusters", [1, 2])
def test_many_corrupted_tables(clusters):
    run(f"corrupted-{clusters}", "cornell", SMALL, ("corrupted_tables",), cell=0.5, clusters=clusters,
        cycles=30_000_000, corruptions=30)


# Capacity for a scene of some thousand patches.
LARGE = {"icu.side_bits": 8, "icu.patch_bits": 11, "noc.rows": 1}


@pytest.mark.nightly
@pytest.mark.parametrize(("scene", "cell"), [("lobby", 0.125), ("room1627", 0.125), ("room1627", 0.0625)])
def test_scenes(scene, cell):
    run(f"{scene}-{cell}", scene, LARGE, ("whole_frusta",), cell=cell, clusters=2, rays=(64, 32), points=(5, 2),
        cycles=2_000_000)
