"""Memory systems of two and four clusters joined by the real network, bus, caches and memory port, at a memory that
others wrote: every patch that golden needs comes once per frustum and cluster, whatever waits.
"""

import json

import cocotb
import pytest

from hw.memsys.cache_policy import CachePolicy
from hw.memsys.fault import Fault
from hw.memsys.memory_formats import MemoryFormats
from hw.noc.network_fault import NetworkFault
from tb.lib.clocking import start
from tb.lib.configurations import config_of
from tb.lib.coverage import Coverage
from tb.lib.no_x import assert_known
from tb.lib.payload import pack, unpack
from tb.lib.runner import BUILD, options, simulate
from tb.lib.stall_patterns import STALL_PAIRS, STALLS
from tb.memsys.joined_path import JoinedPath
from tb.memsys.path_bench import BASE, COVERED, Bench, scene
from tb.memsys.test_memory_path import SMALL
from tb.memsys.test_third_party_memory import Regions, attach, stall

MODULE = "tb.memsys.test_joined_path"
# Stalls of the memory are no silence.
JOINED = {**SMALL, "memory.timeout_bits": 12, "memory.outstanding": 8, "memory.burst_beats": 8,
          "memory.length_bits": 5}
FOUR = {"noc.columns": 2, "noc.rows": 2, "memsys.reply_ids": 4, "memsys.bus_requests": 4, "memsys.cache_fetches": 4,
        "memsys.cell_lines": 32, "memsys.patch_lines": 32}
# Networks of four clusters, another width of memory, larger scenes, patch stores.
VARIANTS = {
    "mesh": ("lobby", 0.125, FOUR),
    "ring": ("lobby", 0.125, {**FOUR, "noc.topology": "ring", "noc.columns": 4, "noc.rows": 1,
                              "noc.virtual_channels": 2, "noc.networks": "virtual", "noc.check": "crc",
                              "noc.arbitration": "age", "memory.data_bits": 512}),
    "stores": ("lobby", 0.125, {**FOUR, "memsys.store_patches": 32, "memsys.store_requests": 8}),
    "room1627": ("room1627", 0.125, {**FOUR, "icu.patch_bits": 11, "memsys.own_entries": 1024,
                                     "memsys.own_patches": 128, "memsys.cache_ways": 4, "memsys.lfu_lines": 32,
                                     "memsys.reply_ids": 8, "memsys.cache_fetches": 8}),
}


class JoinedBench(Bench):
    """Nothing is a model but what is behind the AXI4 port.

    Parameters
    ----------
    memory
        Stalls of its channels.
    """

    def surround(self, *, memory="none", ram=None):
        """The memory, if there is none yet."""
        formats = MemoryFormats(self.config)
        self.dut.window.value = pack(formats.window, {"base": BASE, "limit": BASE + len(self.image)})
        if ram is None:
            ram = attach(self.dut, Regions(self.image, base=BASE))
        self.ram = ram
        stall(ram, (memory, "random") if memory != "none" else ("none",), self.seed)

    def leave(self):
        """It stays: it may owe beats."""

    def again(self, **given):
        """At the same memory."""
        return super().again(ram=self.ram, **given)

    async def frustum(self, share=1.0):
        """No unit in between finds a fault."""
        met = await super().frustum(share)
        found = unpack(MemoryFormats(self.config).fault, int(self.dut.memory_fault.value))
        assert Fault(found["code"]) is Fault.NONE
        for k in range(self.clusters):
            assert NetworkFault(int(getattr(self.dut, f"network_fault__{k}").value)) is NetworkFault.NONE
        return met


@cocotb.test()
async def whole_frusta(dut):
    """Frusta one after the other, as golden says; caches of all policies."""
    await start(dut, cycles=options()["cycles"])
    coverage = Coverage(COVERED)
    bench = JoinedBench(dut)
    for number, policy in enumerate(options()["policies"]):
        await bench.load(policy)
        if number == 0:
            assert_known(dut, [f"{name}__{k}" for k in range(bench.clusters) for name in ("i_cell", "o_vertex")])
        for share in options()["shares"]:
            bench.cover(coverage, await bench.frustum(share))
    coverage.check()


@cocotb.test()
async def every_pair_of_stalls(dut):
    """Cells, the intersection unit and the memory wait in every way; a short frustum each."""
    await start(dut, cycles=options()["cycles"])
    bench = JoinedBench(dut)
    await bench.load()
    for number, (source, sink) in enumerate(STALL_PAIRS):
        bench = bench.again(source=source, sink=sink, memory=[*STALLS][(number + number // 5) % 5])
        await bench.frustum(options()["share"])


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing of before a reset comes after it, of whatever was in flight; tables stay."""
    await start(dut, cycles=options()["cycles"])
    bench = JoinedBench(dut)
    await bench.load()
    await bench.after_resets((40, 110, 200), options()["share"])


def run(name, cases, *, made=("cornell", 0.25), changes=None, shares=(1.0, 0.4), share=0.15,
        policies=("LRU",), cycles=60_000):
    changes = {**JOINED, **(changes or {})}
    config = config_of(changes)
    path = (BUILD / "vectors" / f"joined_path-{name}.json").resolve()
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(scene(*made, config.noc.nodes)))
    simulate(JoinedPath(config=config), MODULE, cases, simulator="icarus", name=f"joined_path-{name}",
             scene=str(path), changes=changes, clusters=config.noc.nodes, shares=shares, share=share,
             policies=policies, cycles=cycles)


@pytest.mark.icarus
@pytest.mark.nightly
def test_a_frustum_of_two_clusters():
    run("two", ("whole_frusta",), shares=(1.0,))


@pytest.mark.icarus
@pytest.mark.nightly
def test_stalls_and_resets():
    run("stalls", ("whole_frusta", "every_pair_of_stalls", "reset_in_flight"),
        policies=[policy.name for policy in CachePolicy], cycles=200_000)


@pytest.mark.icarus
@pytest.mark.nightly
@pytest.mark.parametrize("name", VARIANTS)
def test_four_clusters(name):
    *made, changes = VARIANTS[name]
    shares = (1.0, 1.0) if "memsys.store_patches" in changes else (1.0,)
    run(name, ("whole_frusta",), made=made, changes=changes, shares=shares, cycles=200_000)
