# amaranth: UnusedElaboratable=no
"""Whole frusta of scenes from cells to vertices: every cell opened once, every patch in them given once, from wherever
it is; whatever waits, whatever comes first; and what is malformed ends in a fault.
"""

import json
import random
import shutil
from pathlib import Path

import cocotb
import numpy as np
import pytest
from cocotb.triggers import ClockCycles, RisingEdge

from golden.ctu.sector import Sector
from golden.memsys.reference_strings import ReferenceStrings
from hw.memsys.cache_policy import CachePolicy
from hw.memsys.memory_system import MemorySystem
from hw.memsys.path_fault import PathFault
from hw.memsys.path_formats import PathFormats
from tb.golden.schedule.scenes import case
from tb.lib.clocking import reset, start
from tb.lib.configurations import config_of
from tb.lib.coverage import Coverage
from tb.lib.no_x import assert_known
from tb.lib.pauses import MATRIX, PAUSES
from tb.lib.payload import pack, unpack
from tb.lib.runner import BUILD, options, simulate
from tb.lib.stream import Monitor, Sink, Source
from tb.lib.timing import documented_latency
from tb.memsys.memory_path import Memory, MemoryPath, Mesh, scene_image
from tb.memsys.patch_words import load_of

MODULE = "tb.memsys.test_memory_path"
CLUSTERS, BASE, NONE = 2, 0x4000, (1 << 32) - 1
# Cells and lists that are not in the tables, patches in every place, short parts of lists, few requests.
SMALL = {"memsys.scene_cells": 1024, "memsys.own_cells": 64, "memsys.own_entries": 128, "memsys.own_patches": 16,
         "memsys.reply_ids": 2, "memsys.bus_requests": 2, "memsys.cell_lines": 8, "memsys.patch_lines": 8,
         "memsys.cache_ways": 2, "memsys.lfu_lines": 4, "memsys.cache_fetches": 2, "memsys.filter_generation_bits": 2,
         "icu.patch_bits": 9, "noc.columns": CLUSTERS, "noc.rows": 1, "memory.timeout_bits": 10}
CASES = ("whole_frusta", "what_is_malformed", "one_vertex_per_cycle")
LONG = ("every_pair_of_pauses", "reset_in_flight")
POLICIES = [policy.name for policy in CachePolicy]
COVERED = ("own cell", "cell of the bus", "list in parts", "empty cell", "own patch", "remote patch", "bus patch",
           "the same cell again", "a patch that another cell has named", "a list that is not here")


def scene(name, cell):
    """Tables of a built-in scene and the cells and patches of a frustum of it, cluster by cluster."""
    made = case(name, rays=(64, 16), cell=cell)
    table, geometry = made.shelling.table, made.geometry
    half = made.record.columns // CLUSTERS
    sectors = tuple(Sector(k * half, (k + 1) * half, 0, made.record.rows) for k in range(CLUSTERS))
    strings = ReferenceStrings.of(made.shelling, [made.record], sectors)
    draw = random.Random(7)
    residence = [draw.choice([(NONE, NONE), (0, None), (1, None)]) for _ in range(len(geometry))]
    used = [0] * CLUSTERS
    for patch, (cluster, address) in enumerate(residence):
        if address is None:
            # Beyond the last address: in main memory only.
            residence[patch] = cluster, used[cluster]
            used[cluster] += 1
    return {"pointer": table.pointer.tolist(), "count": table.count.tolist(),
            "lists": table.patches.read(np.arange(len(table.patches))).tolist(),
            "vertices": geometry.vertices.tolist(), "surface": np.asarray(geometry.surface).tolist(),
            "residence": residence, "cells": [string.tolist() for string in strings.cells[0]],
            "patches": [string.tolist() for string in strings.patches[0]]}


class Bench:
    """Clusters with a scene."""

    def __init__(self, dut, *, source="none", sink="none", latency=30, delay=20, given=None, fails=()):
        self.dut, self.seed, self.config = dut, options()["seed"], config_of(options()["changes"])
        self.scene = given or json.loads(Path(options()["scene"]).read_text())
        members = MemorySystem(config=self.config).signature.members
        self.formats = PathFormats(self.config)
        self.shapes = {name: member.signature.members["payload"].shape for name, member in members.items()
                       if member.is_signature}
        self._counters, self._fault = members["counters"].shape, members["fault"].shape
        self.random = random.Random(self.seed)
        image, bases = scene_image(*(self.scene[name] for name in
                                     ("pointer", "count", "lists", "vertices", "surface")))
        self.bases = {name: BASE + offset for name, offset in bases.items()}
        self.memory = Memory(dut, self.config, image, base=BASE, latency=latency, seed=self.seed,
                             fails=[self.bases[name] + offset for name, offset in fails])
        self.mesh = Mesh(dut, self.config, CLUSTERS, delay=delay, seed=self.seed)
        self.sources = [Source(dut, f"i_cell__{k}", pauses=PAUSES[source](self.seed + k)) for k in range(CLUSTERS)]
        self.starts = [Source(dut, f"i_start__{k}") for k in range(CLUSTERS)]
        self.sinks = [Sink(dut, f"o_vertex__{k}", pauses=PAUSES[sink](self.seed + k + 5)) for k in range(CLUSTERS)]
        self.edge = RisingEdge(dut.clk)

    async def load(self, policy="LRU"):
        """Tables and resident sets, all clusters at once; empty caches."""
        dut, scene, formats = self.dut, self.scene, self.formats
        dut.scene.value = pack(formats.scene, {
            "cells": scene.get("cells_there", len(scene["count"])), "lists": len(scene["lists"]),
            "patches": len(scene["vertices"])})
        dut.bases.value = pack(formats.bases, self.bases)
        loads = {
            "i_load_cells": [{"address": k, "record": {"pointer": pointer, "count": count}}
                             for k, (pointer, count) in enumerate(zip(scene["pointer"], scene["count"], strict=True))],
            "i_load_lists": [{"address": k, "record": patch} for k, patch in enumerate(scene["lists"])],
            "i_load_types": [{"address": k, "record": {"cluster": cluster, "address": address}}
                             for k, (cluster, address) in enumerate(scene["residence"])]}
        tasks = []
        for k in range(CLUSTERS):
            getattr(dut, f"clear__{k}").value = 0
            for name, items in loads.items():
                source = Source(dut, f"{name}__{k}")
                tasks.append(cocotb.start_soon(source.send([pack(self.shapes[name], item) for item in items])))
            held = [load for patch, (cluster, address) in enumerate(scene["residence"]) if cluster == k
                    for load in load_of(address, patch, scene["surface"][patch], scene["vertices"][patch])]
            source = Source(dut, f"i_load_geometry__{k}")
            tasks.append(cocotb.start_soon(source.send([pack(self.shapes["i_load_geometry"], load) for load in held])))
        invalidate = Source(dut, "i_invalidate")
        for task in tasks:
            await task
        await invalidate.send([CachePolicy[policy].value])
        await ClockCycles(dut.clk, 6)

    def met(self, cluster, share=1.0):
        """The cells of a cluster's frustum as they are met: in another order, some of them again."""
        cells = self.scene["cells"][cluster]
        cells = cells[:int(len(cells) * share)]
        again = [self.random.choices(cells, k=self.random.choice([0, 0, 0, 2])) for _ in cells]
        return [cell for one, others in zip(cells, again, strict=True) for cell in [one, *others]]

    def expected(self, cells):
        """Patches of some cells."""
        scene = self.scene
        return {patch for cell in cells
                for patch in scene["lists"][scene["pointer"][cell]:scene["pointer"][cell] + scene["count"][cell]]}

    async def begin(self):
        tasks = [cocotb.start_soon(one.send([0])) for one in self.starts]
        for sink in self.sinks:
            sink.items.clear()
            sink.cycles.clear()
        for task in tasks:
            await task

    async def until_drained(self):
        """All clusters say so; nothing comes afterwards."""
        drained = [getattr(self.dut, f"drained__{k}") for k in range(CLUSTERS)]
        await self.edge
        await self.edge
        while not all(int(one.value) for one in drained):
            await self.edge
        before = [len(sink.items) for sink in self.sinks]
        for _ in range(60):
            await self.edge
            assert all(int(one.value) for one in drained), "what is drained must stay so"
        assert [len(sink.items) for sink in self.sinks] == before, "something came after the end"

    async def frustum(self, share=1.0):
        """A frustum, as golden says."""
        await self.begin()
        met = [self.met(k, share) for k in range(CLUSTERS)]
        tasks = [cocotb.start_soon(source.send(cells)) for source, cells in zip(self.sources, met, strict=True)]
        for task in tasks:
            await task
        await self.until_drained()
        for k, (sink, cells) in enumerate(zip(self.sinks, met, strict=True)):
            self.compare(k, sink.items, cells)
            assert self.fault(k) == (PathFault.NONE, 0)
        return met

    def compare(self, cluster, items, cells):
        """Every patch of the cells once, its vertices together; and how many came from where."""
        scene = self.scene
        came = [unpack(self.shapes["o_vertex"], item) for item in items]
        assert len(came) % 4 == 0
        patches = []
        for k in range(0, len(came), 4):
            four = came[k:k + 4]
            patch = four[0]["patch"]
            assert all(one["patch"] == patch for one in four), "the vertices of a patch must stay together"
            assert [one["vertex"] for one in four] == scene["vertices"][patch]
            assert all(one["surface"] == scene["surface"][patch] for one in four)
            patches.append(patch)
        assert len(set(patches)) == len(patches), "a patch must come once"
        assert set(patches) == self.expected(cells)
        counters = unpack(self._counters, int(getattr(self.dut, f"counters__{cluster}").value))
        assert (counters["seen"], counters["opened"]) == (len(cells), len(set(cells)))
        assert counters["found"] == len(patches)
        assert counters["named"] == sum(scene["count"][cell] for cell in set(cells))
        room = self.config.memsys.own_patches
        where = [at if address < room else NONE for at, address in (scene["residence"][patch] for patch in patches)]
        assert counters["own"] == where.count(cluster)
        assert counters["remote"] == len(where) - where.count(cluster) - where.count(NONE)
        assert counters["hits"] + counters["misses"] == where.count(NONE)

    def fault(self, cluster):
        found = unpack(self._fault, int(getattr(self.dut, f"fault__{cluster}").value))
        return PathFault(found["code"]), found["number"]

    def stop(self):
        self.memory.stop()
        self.mesh.stop()
        for sink in self.sinks:
            sink.stop()
        for source in (*self.sources, *self.starts):
            source.valid.value = 0

    def cover(self, coverage, met):
        """What the cells of a frustum are."""
        memsys, scene = self.config.memsys, self.scene
        for cluster, cells in enumerate(met):
            count, pointer = (np.array(scene[name])[cells] for name in ("count", "pointer"))
            is_own = (np.array(cells) < memsys.own_cells) & (pointer + count <= memsys.own_entries)
            patches = [scene["residence"][patch] for patch in self.expected(cells)]
            coverage.hit_all({
                "own cell": is_own, "cell of the bus": ~is_own & (count > 0), "empty cell": count == 0,
                "list in parts": ~is_own & (count > memsys.reply_ids),
                "a list that is not here": (np.array(cells) < memsys.own_cells) & ~is_own,
                "own patch": [at == cluster for at, _ in patches],
                "remote patch": [at == 1 - cluster for at, _ in patches],
                "bus patch": [at == NONE for at, _ in patches],
                "the same cell again": len(cells) > len(set(cells)),
                "a patch that another cell has named": count.sum() > len(patches)})


@cocotb.test()
async def whole_frusta(dut):
    """Frusta one after the other, each with its cells and patches; caches of all policies; the tags run out."""
    await start(dut, cycles=40_000)
    coverage = Coverage(COVERED)
    bench = Bench(dut)
    for policy in options()["policies"]:
        await bench.load(policy)
        assert_known(dut, [f"{name}__{k}" for k in range(CLUSTERS) for name in bench.shapes if name[2:] != "bus"])
        for share in (1.0, 0.4) if policy == "LRU" else (0.3,):
            bench.cover(coverage, await bench.frustum(share))
    assert bench.mesh.asked
    coverage.check()


@cocotb.test()
async def every_pair_of_pauses(dut):
    """Cells and the intersection unit wait in every way; a short frustum each."""
    await start(dut, cycles=40_000)
    bench = Bench(dut)
    await bench.load()
    bench.stop()
    for number, (source, sink) in enumerate(MATRIX):
        bench = Bench(dut, source=source, sink=sink, latency=5 + number, delay=1 + 3 * number)
        await bench.frustum(options()["share"])
        bench.stop()


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing of before a reset comes after it; tables stay."""
    await start(dut, cycles=30_000)
    bench = Bench(dut)
    await bench.load()
    for wait in (30, 90, 170):
        await bench.begin()
        tasks = [cocotb.start_soon(source.send(bench.met(k))) for k, source in enumerate(bench.sources)]
        await ClockCycles(dut.clk, wait)
        for task in tasks:
            task.cancel()
        bench.stop()
        await reset(dut)
        bench = Bench(dut)
        await Source(dut, "i_invalidate").send([CachePolicy.LRU.value])
        await ClockCycles(dut.clk, 40)
        assert not any(sink.items for sink in bench.sinks)
        await bench.frustum(0.3)


def malformed():
    """A scene of eight patches in main memory, and of each kind of fault a cell that leads to it."""
    return {
        # 0: a list that is none, here; 1: a patch that there is not; 2: a residence that is none; 3: held by nobody;
        # 4: a record that cannot be read; 5: as it should be; from 64 on asked of the bus, 65: a list that is none.
        "pointer": [30, 0, 1, 2, 3, 4, *[0] * 58, 5, 8, 5], "count": [5, 1, 1, 1, 1, 2, *[0] * 58, 2, 1 << 31, 1],
        "lists": [300, 6, 7, 2, 0, 1, 3, 301, *[4] * 24], "vertices": [[[k, 2 * k + j, 5 + j] for j in range(4)]
                                                                       for k in range(8)],
        "surface": list(range(8)), "cells_there": 67,
        "residence": [(0, 0), (NONE, NONE), (NONE, NONE), (1, 3), (NONE, NONE), (1, 1), (9, 0), (1, 2)]}


@cocotb.test()
async def what_is_malformed(dut):
    """Each fault is told, with the cell or patch; all else comes; nothing hangs; and the next frustum is right."""
    await start(dut, cycles=30_000)
    given = malformed()
    bench = Bench(dut, given=given, fails=[("patches", 2 * 64 + 24)])
    await bench.load()
    nowhere = [[0, 0, 0]] * 4
    # Patch 7 is said to be at an address where cluster 1 has another one.
    loads = load_of(2, 3, 3, given["vertices"][3])
    await Source(dut, "i_load_geometry__1").send([pack(bench.shapes["i_load_geometry"], load) for load in loads])
    good = [5, 64]
    for cells, fault, number, extra in (
            ([0], PathFault.LIST, 0, []), ([1], PathFault.PATCH, 1 << 9, []), ([2], PathFault.RESIDENCE, 6, []),
            ([70], PathFault.CELL, 70, []), ([1 << 20], PathFault.CELL, 1 << 20, []), ([4], PathFault.BUS, 2, []),
            ([65], PathFault.BUS, 65, []), ([3], PathFault.NONE, 0, [(7, nowhere)])):
        await bench.begin()
        await bench.sources[0].send([*good[:1], *cells, *good[1:]])
        await bench.until_drained()
        assert bench.fault(0) == (fault, number), cells
        came = [unpack(bench.shapes["o_vertex"], item) for item in bench.sinks[0].items]
        found = [(came[k]["patch"], [one["vertex"] for one in came[k:k + 4]]) for k in range(0, len(came), 4)]
        wanted = [(patch, given["vertices"][patch]) for patch in bench.expected(good)] + extra
        assert sorted(found) == sorted(wanted), cells
        assert bench.fault(1) == ((PathFault.RESIDENCE, 7) if extra else (PathFault.NONE, 0))
        for k in range(CLUSTERS):
            getattr(dut, f"clear__{k}").value = 1
        await ClockCycles(dut.clk, 2)
        for k in range(CLUSTERS):
            getattr(dut, f"clear__{k}").value = 0
    # The network never answers.
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


def run(name, cell, changes, simulator, cases=CASES + LONG, policies=POLICIES, share=0.15):
    path = (BUILD / "vectors" / f"memory_path-{name}.json").resolve()
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(scene(name, cell)))
    simulate(MemoryPath(config=config_of(changes), clusters=CLUSTERS), MODULE, cases, simulator=simulator,
             name=f"memory_path-{name}-{simulator}", scene=str(path), changes=changes, share=share,
             policies=policies)


ICARUS = pytest.mark.skipif(shutil.which("iverilog") is None,
                            reason="there is no iverilog here: apt-get install iverilog")


@ICARUS
def test_frusta_and_faults():
    run("cornell", 0.25, SMALL, "icarus", CASES, ["LRU"])


@ICARUS
@pytest.mark.nightly
def test_all_policies_and_pauses():
    run("cornell", 0.25, SMALL, "icarus")


@pytest.mark.sim
def test_in_verilator():
    run("cornell", 0.25, SMALL, "verilator")
