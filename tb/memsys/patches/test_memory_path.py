"""Whole frusta of scenes from cells to vertices: every cell opened once, every patch in them given once, from wherever
it is; whatever waits, whatever comes first; and what is malformed ends in a fault.
"""

import json
import random

import cocotb
import pytest
from cocotb.triggers import ClockCycles, RisingEdge

from hw.lib.payload import pack, unpack
from hw.memsys.bus.cache_policy import CachePolicy
from hw.memsys.memory_system import MemorySystem
from hw.memsys.patches.path_fault import PathFault
from tb.lib.clocking import start
from tb.lib.configurations import config_of
from tb.lib.coverage import Coverage
from tb.lib.no_x import assert_known
from tb.lib.runner import BUILD, options, simulate
from tb.lib.stall_patterns import STALL_PAIRS
from tb.lib.stream import Monitor, Source
from tb.lib.timing import documented_latency
from tb.memsys.memory_path import MemoryPath
from tb.memsys.patch_words import load_of
from tb.memsys.path_bench import COVERED, NONE, Bench, scene

CLUSTERS = 2
# Cells and lists that are not in the tables, patches at every address, short parts of lists, few requests.
SMALL = {"memsys.scene_cells": 1024, "memsys.own_cells": 64, "memsys.own_entries": 128, "memsys.own_patches": 16,
         "memsys.reply_ids": 2, "memsys.bus_requests": 2, "memsys.cell_lines": 8, "memsys.patch_lines": 8,
         "memsys.cache_ways": 2, "memsys.lfu_lines": 4, "memsys.cache_fetches": 2, "memsys.filter_generation_bits": 2,
         "icu.patch_bits": 9, "noc.columns": CLUSTERS, "noc.rows": 1, "memory.timeout_bits": 10,
         "memsys.store_patches": 0}
CASES = ("whole_frusta", "what_is_malformed", "one_vertex_per_cycle")
LONG = ("every_pair_of_stalls", "reset_in_flight")
# A patch store that replaces patches; and one whose requests are in a known order, as all lists are here.
STORE = {**SMALL, "memsys.store_patches": 8, "memsys.store_requests": 4}
EXACT = {**STORE, "memsys.own_cells": 1024, "memsys.own_entries": 1024}
POLICIES = [policy.name for policy in CachePolicy]


@cocotb.test()
async def whole_frusta(dut):
    """Frusta one after the other, each with its cells and patches; caches of all policies; the tags run out."""
    await start(dut, cycles=options()["cycles"])
    coverage = Coverage(COVERED)
    bench = Bench(dut)
    for policy in options()["policies"]:
        await bench.load(policy)
        assert_known(dut, [f"{name}__{k}" for k in range(CLUSTERS) for name in bench.shapes if name[2:] != "bus"])
        for share in (1.0, 0.4) if policy == "LRU" else (0.3,):
            bench.cover(coverage, await bench.frustum(share))
    assert bench.mesh.request_count
    coverage.check()


@cocotb.test()
async def every_pair_of_stalls(dut):
    """Cells and the intersection unit wait in every way; a short frustum each."""
    await start(dut, cycles=40_000)
    bench = Bench(dut)
    await bench.load()
    for number, (source, sink) in enumerate(STALL_PAIRS):
        bench = bench.again(source=source, sink=sink, latency=5 + number, delay=1 + 3 * number)
        await bench.frustum(options()["share"])


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing of before a reset comes after it; tables stay."""
    await start(dut, cycles=30_000)
    bench = Bench(dut)
    await bench.load()
    await bench.after_resets((30, 90, 170), 0.3)


@cocotb.test()
async def store_counts(dut):
    """Golden's counters, to the patch, of frusta that find what others have left in the stores; a load empties them, of
    patches of other nodes alone too.
    """
    await start(dut, cycles=options()["cycles"])
    bench = Bench(dut, source="random", sink="random")
    for shares in ((1.0, 1.0, 0.3, 1.0), (0.5, 1.0)):
        await bench.load()
        for share in shares:
            await bench.frustum(share)
    await bench.reload()
    await bench.frustum()
    requests = sum(store.hits + store.misses for store in bench.stores)
    assert all(store.hits > 20 and store.misses > 20 for store in bench.stores), "both occur"
    assert bench.mesh.request_count < requests


def malformed():
    """A scene of eight patches in main memory, and of each kind of fault a cell that leads to it."""
    return {
        # 0: a list that is none, here; 1: a patch that there is not; 2: a residence that is none; 3: held by none;
        # 4: a record that cannot be read; 5: as it should be; from 64 on the bus is read, 65: a list that is none.
        "pointer": [30, 0, 1, 2, 3, 4, *[0] * 58, 5, 8, 5], "count": [5, 1, 1, 1, 1, 2, *[0] * 58, 2, 1 << 31, 1],
        "lists": [300, 6, 7, 2, 0, 1, 3, 301, *[4] * 24], "vertices": [[[k, 2 * k + j, 5 + j] for j in range(4)]
                                                                       for k in range(8)],
        "surface": list(range(8)), "cells_there": 67,
        "residence": [(0, 0), (NONE, NONE), (NONE, NONE), (1, 3), (NONE, NONE), (1, 1), (9, 0), (1, 2)]}


@cocotb.test()
async def what_is_malformed(dut):
    """Each fault is reported where the cell or patch is requested; all else comes; nothing hangs; and the next frustum
    is right.
    """
    await start(dut, cycles=30_000)
    given = malformed()
    bench = Bench(dut, given=given, fails=[("patches", 2 * 64 + 24)])
    await bench.load()
    nowhere = [[0, 0, 0]] * 4
    # A list that is none is found when a table is loaded, or when the bus reads it.
    no_list = PathFault.BUS if bench.config.memsys.own_cells <= 65 else PathFault.LIST
    # Patch 7 is said to be at an address where cluster 1 has another one.
    loads = load_of(2, 3, 3, given["vertices"][3])
    await Source(dut, "i_load_geometry__1").send([pack(bench.shapes["i_load_geometry"], load) for load in loads])
    good = [5, 64]
    for cells, fault, number, extra in (
            ([0], PathFault.LIST, 0, []), ([1], PathFault.PATCH, 1 << 9, []), ([2], PathFault.RESIDENCE, 6, []),
            ([70], PathFault.CELL, 70, []), ([1 << 20], PathFault.CELL, 1 << 20, []), ([4], PathFault.BUS, 2, []),
            ([65], no_list, 65, []), *[([3], PathFault.RESIDENCE, 7, [(7, nowhere)])] * 2):
        await bench.begin()
        await bench.sources[0].send([*good[:1], *cells, *good[1:]])
        await bench.until_drained()
        assert bench.fault(0) == (fault, number), cells
        came = [unpack(bench.shapes["o_vertex"], item) for item in bench.sinks[0].items]
        found = [(came[k]["patch"], [one["vertex"] for one in came[k:k + 4]]) for k in range(0, len(came), 4)]
        required = [(patch, given["vertices"][patch]) for patch in bench.expected(good)] + extra
        assert sorted(found) == sorted(required), f"{cells}: each patch once, when its source answers"
        assert bench.fault(1) == (PathFault.NONE, 0), "the cluster that answers has no fault"
        for k in range(CLUSTERS):
            getattr(dut, f"clear__{k}").value = 1
        await ClockCycles(dut.clk, 2)
        for k in range(CLUSTERS):
            getattr(dut, f"clear__{k}").value = 0
    # The network never answers, and nothing is in a patch store.
    await bench.load()
    bench.mesh.stop()
    await bench.begin()
    await bench.sources[0].send([64])
    for _ in range(6 << bench.config.memory.timeout_bits):
        await RisingEdge(dut.clk)
        if bench.fault(0)[0] is not PathFault.NONE:
            break
    assert bench.fault(0)[0] is PathFault.TIMEOUT
    assert not int(dut.drained__0.value)


@cocotb.test()
async def one_vertex_per_cycle(dut):
    """Of patches in the cluster's own memory one vertex per cycle, after the latency that the docstring states."""
    await start(dut, cycles=20_000)
    draw = random.Random(2)
    count = 16
    given = {
        "pointer": list(range(count)), "count": [1] * count, "lists": list(range(count)),
        "vertices": [[[draw.randrange(1 << 20) for _ in range(3)] for _ in range(4)] for _ in range(count)],
        "surface": [-1] * count, "residence": [(0, k) for k in range(count)]}
    bench = Bench(dut, given=given)
    await bench.load()
    await bench.begin()
    entered = Monitor(dut, "i_cell__0")
    await bench.sources[0].send([cell for cell in range(count) for _ in range(4)])
    await bench.until_drained()
    cycles = bench.sinks[0].cycles
    assert entered.cycles == list(range(entered.cycles[0], entered.cycles[0] + 4 * count)), "one cell per cycle"
    assert cycles == list(range(cycles[0], cycles[0] + 4 * count)), "one vertex per cycle"
    assert cycles[0] - entered.cycles[0] == documented_latency(MemorySystem, bench.config)


@cocotb.test()
async def one_kept_vertex_per_cycle(dut):
    """Of patches that another cluster holds one vertex per cycle, from the second frustum on."""
    await start(dut, cycles=20_000)
    draw = random.Random(3)
    count = options()["kept"]
    given = {
        "pointer": list(range(count)), "count": [1] * count, "lists": list(range(count)),
        "vertices": [[[draw.randrange(1 << 20) for _ in range(3)] for _ in range(4)] for _ in range(count)],
        "surface": [-1] * count, "residence": [(1, k) for k in range(count)]}
    bench = Bench(dut, given=given)
    await bench.load()
    for frustum in range(3):
        await bench.begin()
        await bench.sources[0].send(range(count))
        await bench.until_drained()
        bench.compare(0, bench.sinks[0].items, list(range(count)))
        cycles = bench.sinks[0].cycles
        assert (cycles == list(range(cycles[0], cycles[0] + 4 * count))) == (frustum > 0), "one vertex per cycle"
    assert bench.mesh.request_count == count


def run(name, scene_name, cell, changes, simulator, cases=CASES + LONG, policies=POLICIES, share=0.15, cycles=40_000):
    path = (BUILD / "vectors" / f"memory_path-{name}.json").resolve()
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(scene(scene_name, cell, CLUSTERS)))
    simulate(MemoryPath(config=config_of(changes), clusters=CLUSTERS), __name__, cases, simulator=simulator,
             name=f"memory_path-{name}-{simulator}", scene=str(path), changes=changes,
             clusters=CLUSTERS, share=share, policies=policies, cycles=cycles,
             kept=changes.get("memsys.store_patches", 0))


@pytest.mark.sim
def test_in_verilator():
    run("cornell", "cornell", 0.25, SMALL, "verilator")


@pytest.mark.icarus
@pytest.mark.sim
def test_patch_stores():
    run("stores", "cornell", 0.25, EXACT, "icarus", ("store_counts", "what_is_malformed", "one_kept_vertex_per_cycle"))


@pytest.mark.icarus
@pytest.mark.nightly
@pytest.mark.parametrize(("scene_name", "cell", "changes", "given"), [
    pytest.param("cornell", 0.25, STORE, {"policies": ["LRU"]}, id="stores-bus"),
    pytest.param("cornell", 0.25, EXACT, {"cases": LONG}, id="stores-stalls"),
    pytest.param("cornell", 0.25, SMALL, {}, id="policies"),
    pytest.param("lobby", 0.125, SMALL, {"cases": ("whole_frusta",), "cycles": 300_000}, id="lobby")])
def test_in_icarus(scene_name, cell, changes, given, request):
    run(request.node.callspec.id, scene_name, cell, changes, "icarus", **given)
