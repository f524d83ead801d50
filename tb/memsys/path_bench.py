"""The testbench of clusters' memory systems: a scene's tables, cells that come, and what golden says of the patches."""

import json
import random
from pathlib import Path

import cocotb
import numpy as np
from cocotb.triggers import ClockCycles, RisingEdge

from golden.engine.ctu.sector import Sector
from golden.engine.memsys.bus.reference_strings import ReferenceStrings
from golden.engine.memsys.patches.patch_store import PatchStore
from hw.lib.payload import pack, unpack
from hw.memsys.bus.cache_policy import CachePolicy
from hw.memsys.memory_system import MemorySystem
from hw.memsys.patches.path_fault import PathFault
from hw.memsys.patches.path_formats import PathFormats
from tb.golden.engine.schedule.scenes import case
from tb.lib.clocking import reset
from tb.lib.configurations import config_of
from tb.lib.runner import options
from tb.lib.stall_patterns import STALLS
from tb.lib.stream import Sink, Source
from tb.memsys.memory_path import Memory, Mesh, scene_image
from tb.memsys.patch_words import load_of

__all__ = ["BASE", "COVERED", "NONE", "Bench", "scene"]

BASE, NONE = 0x4000, (1 << 32) - 1
COVERED = ("own cell", "cell of the bus", "list in parts", "empty cell", "own patch", "remote patch", "bus patch",
           "the same cell again", "a patch that another cell has named", "a list that is not here")


def scene(name: str, cell: float, clusters: int) -> dict:
    """Tables of a built-in scene and the cells and patches of a frustum of it, cluster by cluster."""
    made = case(name, rays=(64, 16), cell=cell)
    table, geometry = made.shelling.table, made.geometry
    part = made.record.columns // clusters
    sectors = tuple(Sector(k * part, (k + 1) * part, 0, made.record.rows) for k in range(clusters))
    strings = ReferenceStrings.of(made.shelling, [made.record], sectors)
    draw = random.Random(7)
    residence = [draw.choice([(NONE, NONE), *((k, None) for k in range(clusters))]) for _ in range(len(geometry))]
    used = [0] * clusters
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
    """Clusters with a scene; memory and network are models that are late by chance.

    Parameters
    ----------
    source, sink
        Stalls of the cells that come and of the vertices that are taken.
    stores
        The clusters' patch stores as they are; empty by default.
    given
        A `scene`, if not the run's.
    around
        Of `surround`.
    """

    def __init__(self, dut, *, source="none", sink="none", stores=None, given=None, **around):
        self.dut, self.seed, self.config = dut, options()["seed"], config_of(options()["changes"])
        self.clusters = options()["clusters"]
        frames = self.config.memsys.store_patches
        self.stores = stores or [PatchStore(frames) if frames else None for _ in range(self.clusters)]
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
        self.edge = RisingEdge(dut.clk)
        self.image = image
        self.surround(**around)
        self.sources = [Source(dut, f"i_cell__{k}", stalls=STALLS[source](self.seed + k)) for k in range(self.clusters)]
        self.starts = [Source(dut, f"i_start__{k}") for k in range(self.clusters)]
        self.sinks = [Sink(dut, f"o_vertex__{k}", stalls=STALLS[sink](self.seed + k + 5)) for k in range(self.clusters)]

    def surround(self, *, latency=30, delay=20, fails=()):
        """Memory, where some beats (region, offset) fail, and network."""
        self.memory = Memory(self.dut, self.config, self.image, base=BASE, latency=latency, seed=self.seed,
                             fails=[self.bases[name] + offset for name, offset in fails])
        self.mesh = Mesh(self.dut, self.config, self.clusters, delay=delay, seed=self.seed)

    async def _watch(self, cluster):
        """From a frustum's beginning on: when the cluster is drained all vertices have left of all patches in the cells
        that have come.
        """
        def wires(name):
            return [getattr(self.dut, f"{name}__{cluster}{part}") for part in ("__valid", "__ready", "__payload")]

        cell, vertex, drained = wires("i_cell"), wires("o_vertex"), getattr(self.dut, f"drained__{cluster}")
        came, patches, left = set(), set(), 0
        while True:
            await self.edge
            if int(drained.value):
                assert left == 4 * len(patches), f"drained after {left} vertices of {len(patches)} patches"
            if all(int(wire.value) for wire in cell[:2]):
                number = int(cell[2].value)
                if number not in came:
                    came.add(number)
                    patches |= self.expected([number])
            left += all(int(wire.value) for wire in vertex[:2])

    async def load(self, policy="LRU"):
        """Tables and resident sets, all clusters at once; empty caches and patch stores."""
        self.clear_stores()
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
        for k in range(self.clusters):
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

    async def reload(self):
        """Patches of a node that no cluster here is."""
        self.clear_stores()
        for reloads in (1, 0):
            for k in range(self.clusters):
                getattr(self.dut, f"reloads__{k}").value = reloads
            await self.edge

    def clear_stores(self):
        """Nothing is kept."""
        for store in self.stores:
            if store is not None:
                store.clear()

    def met(self, cluster, share=1.0):
        """The cells of a cluster's frustum as they are met: in another order, some of them again."""
        cells = self.scene["cells"][cluster]
        cells = cells[:int(len(cells) * share)]
        again = [self.random.choices(cells, k=self.random.choice([0, 0, 0, 2])) for _ in cells]
        return [cell for one, others in zip(cells, again, strict=True) for cell in [one, *others]]

    def list_of(self, cell):
        """Patches of a cell."""
        scene = self.scene
        return scene["lists"][scene["pointer"][cell]:scene["pointer"][cell] + scene["count"][cell]]

    def expected(self, cells):
        """Patches of some cells."""
        return {patch for cell in cells for patch in self.list_of(cell)}

    async def begin(self):
        """A frustum; of the one before nothing is kept."""
        tasks = [cocotb.start_soon(one.send([0])) for one in self.starts]
        for sink in self.sinks:
            sink.items.clear()
            sink.cycles.clear()
        for task in tasks:
            await task

    async def until_drained(self):
        """All clusters say so; nothing comes afterwards."""
        drained = [getattr(self.dut, f"drained__{k}") for k in range(self.clusters)]
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
        """A frustum, as golden says: every patch that it needs, once."""
        await self.begin()
        met = [self.met(k, share) for k in range(self.clusters)]
        watches = [cocotb.start_soon(self._watch(k)) for k in range(self.clusters)]
        tasks = [cocotb.start_soon(source.send(cells)) for source, cells in zip(self.sources, met, strict=True)]
        for task in tasks:
            await task
        await self.until_drained()
        for watch in watches:
            watch.cancel()
        for k, (sink, cells) in enumerate(zip(self.sinks, met, strict=True)):
            self.compare(k, sink.items, cells)
            if share == 1:
                # All cells need all patches of the scene, each once.
                assert self.expected(cells) == set(self.scene["patches"][k])
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
        # Own, remote and fetched patches come when their sources answer.
        assert set(patches) == self.expected(cells)
        counters = unpack(self._counters, int(getattr(self.dut, f"counters__{cluster}").value))
        # A cell that is met again is not opened again, and names its patches once.
        assert (counters["seen"], counters["opened"]) == (len(cells), len(set(cells)))
        assert counters["found"] == len(patches)
        assert counters["named"] == sum(scene["count"][cell] for cell in dict.fromkeys(cells))
        memsys, lists = self.config.memsys, [self.list_of(cell) for cell in dict.fromkeys(cells)]
        where = {patch: at if address < memsys.own_patches else NONE
                 for patch, (at, address) in enumerate(scene["residence"])}
        # The patch store's requests, in their order if all lists are here.
        others = [patch for patch in dict.fromkeys(patch for one in lists for patch in one) if where[patch] != cluster]
        assert counters["own"] == len(patches) - len(others)
        assert sum(counters[name] for name in ("kept", "remote", "hits", "misses")) == len(others)
        if self.stores[cluster] is None:
            assert counters["kept"] == 0
        elif len(scene["count"]) <= memsys.own_cells and len(scene["lists"]) <= memsys.own_entries:
            others = [patch for patch in others if not self.stores[cluster].request(patch)]
            assert counters["kept"] == len(patches) - counters["own"] - len(others)
        else:
            return
        assert counters["remote"] == sum(where[patch] != NONE for patch in others)
        assert counters["hits"] + counters["misses"] == sum(where[patch] == NONE for patch in others)

    def fault(self, cluster):
        """Code and number."""
        found = unpack(self._fault, int(getattr(self.dut, f"fault__{cluster}").value))
        return PathFault(found["code"]), found["number"]

    def again(self, **given):
        """A testbench like this one, stopped, with what stays of its surroundings."""
        self.stop()
        return type(self)(self.dut, stores=self.stores, **given)

    async def after_resets(self, waits, share):
        """After a reset so many cycles into a frustum nothing of before it comes, and a part of a frustum is right."""
        bench = self
        for wait in waits:
            await bench.begin()
            tasks = [cocotb.start_soon(source.send(bench.met(k))) for k, source in enumerate(bench.sources)]
            await ClockCycles(bench.dut.clk, wait)
            for task in tasks:
                task.cancel()
            bench.stop()
            await reset(bench.dut)
            bench.clear_stores()
            bench = bench.again()
            await Source(bench.dut, "i_invalidate").send([CachePolicy.LRU.value])
            await ClockCycles(bench.dut.clk, 40)
            assert not any(sink.items for sink in bench.sinks)
            await bench.frustum(share)

    def stop(self):
        """Give nothing more, and take nothing."""
        self.leave()
        for sink in self.sinks:
            sink.stop()
        for source in (*self.sources, *self.starts):
            source.valid.value = 0

    def leave(self):
        """Memory and network answer nothing more."""
        self.memory.stop()
        self.mesh.stop()

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
                "remote patch": [at not in (cluster, NONE) for at, _ in patches],
                "bus patch": [at == NONE for at, _ in patches],
                "the same cell again": len(cells) > len(set(cells)),
                "a patch that another cell has named": count.sum() > len(patches)})
