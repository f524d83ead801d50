"""The system bus interface with the real port behind it, at a memory that others wrote: golden's hits access by access,
whatever waits and whatever memory cannot read.
"""

import random

import cocotb
import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from cocotb.triggers import ClockCycles, RisingEdge

from hw.memsys.axi_signature import AxiSignature
from hw.memsys.cache_policy import CachePolicy
from hw.memsys.fault import Fault
from hw.memsys.main_memory_port import MainMemoryPort
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.path_formats import PathFormats, RequestKind
from hw.memsys.system_bus_interface import READERS, SystemBusInterface
from tb.lib.clocking import reset, start
from tb.lib.configurations import config_of
from tb.lib.no_x import assert_known
from tb.lib.payload import pack, unpack
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.stall_patterns import STALL_PAIRS, STALLS
from tb.lib.stream import Sink, Source
from tb.memsys.bus_scene import BusScene
from tb.memsys.faulty_memory import READ_FAULTS, BusFault, FaultyMemory
from tb.memsys.memory_bench import ModelAtPort
from tb.memsys.test_third_party_memory import Regions, attach, stall

MODULE = "tb.memsys.test_bus_at_memory"
BASE, LINES = 0x2000, 8
SMALL = {"memsys.reply_ids": 4, "memsys.cache_fetches": 4, "icu.patch_bits": 8, "memsys.cell_lines": LINES,
         "memsys.patch_lines": LINES, "memsys.cache_ways": 2, "memsys.lfu_lines": 4, "memsys.lfu_count_bits": 3,
         "memory.outstanding": 4, "memory.burst_beats": 8, "memory.length_bits": 5, "memory.timeout_bits": 12}
POLICIES = list(CachePolicy)
SHARED = ("i_invalidate", "i_request", "o_reply", "scene", "bases")
# Until late beats have come.
ATTEMPTS = 40
# What memory cannot read: these patches, and the beats with these cells' records, 8 bytes each.
FAILED = {RequestKind.PATCH: (5,), RequestKind.CELL: (2, 3)}


class BusAtMemory(wiring.Component):
    """The interface at the port."""

    def __init__(self, *, config):
        self.interface = SystemBusInterface(config=config)
        self.port = MainMemoryPort(config=config, tag=range(READERS))
        formats, members = MemoryFormats(config), self.interface.signature.members
        super().__init__({**{name: members[name] for name in SHARED}, "axi": Out(AxiSignature(config=config)),
                          "window": In(formats.window), "fault": Out(formats.fault), "clear": In(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.interface, m.submodules.port = interface, port = self.interface, self.port
        wiring.connect(m, wiring.flipped(self.i_invalidate), interface.i_invalidate)
        wiring.connect(m, wiring.flipped(self.i_request), interface.i_request)
        for out, given in zip(self.o_reply, interface.o_reply, strict=True):
            wiring.connect(m, given, wiring.flipped(out))
        wiring.connect(m, interface.o_request, port.i_read)
        wiring.connect(m, port.o_read, interface.i_reply)
        wiring.connect(m, port.axi, wiring.flipped(self.axi))
        m.d.comb += [interface.scene.eq(self.scene), interface.bases.eq(self.bases),
                     port.read_window.eq(self.window), self.fault.eq(port.fault), port.clear.eq(self.clear)]
        return m


class Bench:
    """Clusters that send requests, and a scene in memory."""

    def __init__(self, dut, *, source="none", sink="none"):
        self.dut, self.config, seed = dut, config_of(options()["changes"]), options()["seed"]
        self.formats, self.scene, self.seed = PathFormats(self.config), BusScene(self.config), seed
        self.requests = Source(dut, "i_request", stalls=STALLS[source](seed))
        self.sinks = [Sink(dut, f"o_reply__{kind.value}", stalls=STALLS[sink](seed + kind.value))
                      for kind in RequestKind]
        dut.scene.value = pack(self.formats.scene, self.scene.counts)
        self.bases = {name: BASE + offset for name, offset in self.scene.bases.items()}
        dut.bases.value = pack(self.formats.bases, self.bases)
        window = MemoryFormats(self.config).window
        dut.window.value = pack(window, {"base": BASE, "limit": BASE + len(self.scene.image)})
        dut.clear.value = 0

    async def send_requests(self, policy, requests, failed=lambda kind, key: False, **given):
        """From empty caches on; golden's hits and records. Returns the number of errors; see `BusScene.check`."""
        for sink in self.sinks:
            sink.items.clear()
        await Source(self.dut, "i_invalidate").send([policy.value])
        await self.requests.send([pack(self.formats.bus_request, {"source": cluster, "item": {
            "kind": kind.value, "key": key}}) for cluster, kind, key in requests])
        by_kind = {kind: [(cluster, key) for cluster, which, key in requests if which is kind] for kind in RequestKind}
        replies = [[] for _ in self.sinks]
        while any(sum(beat["last"] for beat in came) < len(by_kind[kind])
                  for kind, came in zip(RequestKind, replies, strict=True)):
            await RisingEdge(self.dut.clk)
            for came, sink in zip(replies, self.sinks, strict=True):
                came += [unpack(self.formats.bus_reply, item) for item in sink.items[len(came):]]
        await ClockCycles(self.dut.clk, 20)
        errors = 0
        for kind, came, sink in zip(RequestKind, replies, self.sinks, strict=True):
            assert len(sink.items) == len(came), "something came after the last reply"
            hit = self.scene.hits(by_kind[kind], policy.name.lower(), LINES)
            errors += self.scene.check(kind, by_kind[kind], hit, came, failed, **given)
        return errors

    def fault(self):
        """Code and address."""
        found = unpack(MemoryFormats(self.config).fault, int(self.dut.fault.value))
        return Fault(found["code"]), found["address"]

    def stop(self):
        """Give nothing more, and take nothing."""
        self.requests.valid.value = 0
        for sink in self.sinks:
            sink.stop()


@cocotb.test()
async def every_pair_of_stalls(dut):
    """Clusters send and accept, and memory answers, in every way; one policy after another."""
    await start(dut, cycles=200_000)
    ram = attach(dut, Regions(BusScene(config_of(options()["changes"])).image, base=BASE))
    for number, (source, sink) in enumerate(STALL_PAIRS):
        bench = Bench(dut, source=source, sink=sink)
        if number == 0:
            await RisingEdge(dut.clk)
            assert_known(dut, ("i_request", "o_reply__0", "o_reply__1"))
        stall(ram, ([*STALLS][(number + number // 5) % 5], "random"), number)
        await bench.send_requests(POLICIES[number % 3], bench.scene.requests(40, seed=number))
        assert bench.fault() == (Fault.NONE, 0)
        bench.stop()


@cocotb.test()
async def a_target_that_raises(dut):
    """What cannot be read is an error, each time that it is requested; all else is right."""
    await start(dut, cycles=60_000)
    config = config_of(options()["changes"])
    scene, cell_bits = BusScene(config), PathFormats(config).cell_bits
    patches, cells = (BASE + scene.bases[name] for name in ("patches", "cells"))
    together = config.memory.beat_bytes // 8
    failed = {kind: {key // size * size + k for key in FAILED[kind] for k in range(size)}
              for kind, size in ((RequestKind.PATCH, 1), (RequestKind.CELL, together))}
    blocks = ({(patches + 64 * key, 64) for key in failed[RequestKind.PATCH]}
              | {(cells + 8 * key, 8) for key in failed[RequestKind.CELL]})
    ram = attach(dut, Regions(scene.image, lambda address: any(
        first <= address < first + size for first, size in blocks), base=BASE))
    stall(ram, ("none", "random"), 3)
    for policy in POLICIES:
        bench = Bench(dut)
        await bench.send_requests(policy, bench.scene.requests(60, seed=policy.value), lambda kind, key: (
            key & (1 << cell_bits) - 1 if kind is RequestKind.CELL else key) in failed[kind])
        code, address = bench.fault()
        assert code is Fault.READ_REPLY
        assert any(first <= address < first + size for first, size in blocks)
        dut.clear.value = 1
        await ClockCycles(dut.clk, 2)
        bench.stop()


@cocotb.test()
async def faults_of_the_bus(dut):
    """A request that memory answers wrongly is an error or right; so is the next one, at once. Memory stays."""
    await start(dut, cycles=400_000)
    draw, config = random.Random(options()["seed"]), config_of(options()["changes"])
    scene = BusScene(config)

    def fresh():
        return FaultyMemory(config, scene.image, base=BASE, latency=5, spread=9, shuffles=True)

    memory, bench = fresh(), Bench(dut)
    port = ModelAtPort(dut, memory)
    for kind in READ_FAULTS:
        memory.arm(BusFault(kind=kind, burst=draw.randrange(9), beat=draw.randrange(8)))
        policy = draw.choice(POLICIES)
        errors = await bench.send_requests(policy, scene.requests(50, seed=len(kind)), errors=True)
        assert memory.struck, kind
        assert not (errors and kind in ("unexpected beat", "last beat again")), kind
        for _ in range(ATTEMPTS):
            errors = await bench.send_requests(policy, scene.requests(30, seed=1), errors=True)
            if not errors:
                break
        assert bool(errors) == memory.lost, kind
        assert bench.fault()[0] is READ_FAULTS[kind]
        if memory.lost:
            port.stop()
            await reset(dut)
            memory = fresh()
            port = ModelAtPort(dut, memory)
        dut.clear.value = 1
        await ClockCycles(dut.clk, 2)
        dut.clear.value = 0
        await bench.send_requests(policy, scene.requests(20, seed=2))
        assert bench.fault()[0] is Fault.NONE
        assert memory.data == scene.image
    port.stop()


@cocotb.test()
async def reset_in_flight(dut):
    """Memory too is reset; nothing of before comes after it."""
    await start(dut, cycles=60_000)
    ram = attach(dut, Regions(BusScene(config_of(options()["changes"])).image, base=BASE))
    draw = random.Random(options()["seed"])
    for number in range(5):
        bench = Bench(dut, sink="random")
        stall(ram, ("random",), number)
        task = cocotb.start_soon(bench.send_requests(CachePolicy.LRU, bench.scene.requests(60, seed=number)))
        await ClockCycles(dut.clk, draw.randrange(20, 250))
        task.cancel()
        bench.stop()
        await reset(dut)
        bench = Bench(dut)
        await ClockCycles(dut.clk, 30)
        assert not any(sink.items for sink in bench.sinks)
        await bench.send_requests(CachePolicy.LRU, bench.scene.requests(20, seed=number))
        bench.stop()


@pytest.mark.nightly
@pytest.mark.parametrize("bits", [64, 256, 512])
@pytest.mark.parametrize("simulator", SIMULATORS[1:])
def test_at_a_memory_of_others(simulator, bits):
    changes = {**SMALL, "memory.data_bits": bits}
    simulate(BusAtMemory(config=config_of(changes)), MODULE,
             ("every_pair_of_stalls", "a_target_that_raises", "reset_in_flight"), simulator=simulator,
             name=f"bus_at_memory-{bits}-{simulator}", changes=changes)


@pytest.mark.icarus
@pytest.mark.nightly
def test_faults_of_the_bus():
    changes = {**SMALL, "memory.timeout_bits": 7}
    simulate(BusAtMemory(config=config_of(changes)), MODULE, ("faults_of_the_bus",), simulator="icarus",
             name="bus_at_memory-faults", changes=changes)
