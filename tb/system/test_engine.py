# amaranth: UnusedElaboratable=no
"""Whole frusta on the whole machine, driven by the host: hits and sums are brute force's."""

from pathlib import Path

import cocotb
import numpy as np
import pytest

from tb.host import Host
from tb.lib.clocking import start
from tb.lib.configurations import config_of
from tb.lib.runner import BUILD, options, simulate
from tb.memsys.memory_bench import ModelAtPort
from tb.memsys.memory_model import MemoryModel
from tb.system.build import engine_text
from tb.system.cocotb_port import CocotbPort
from tb.system.scenes import frusta, load, save

MODULE = "tb.system.test_engine"
BASE = 0x1_0000_4000
# Room for small frusta, and little of it: resident sets, lists and caches that are too small.
SMALL = {"icu.rays": 1024, "icu.side_bits": 6, "icu.patch_bits": 9, "icu.generation_bits": 2,
         "memsys.scene_cells": 1024, "memsys.own_cells": 64, "memsys.own_entries": 128, "memsys.own_patches": 16,
         "memsys.cell_lines": 8, "memsys.patch_lines": 8, "memsys.lfu_lines": 4, "memsys.cache_fetches": 2,
         "memsys.filter_generation_bits": 2, "ctu.ray_slots": 256, "ctu.grid_row_bits": 7, "ctu.grid_column_bits": 9,
         "ctu.shell_bits": 4, "ctu.subshell_bits": 6, "ctu.near_cell_bits": 5, "noc.rows": 1}


class Bench:
    """The engine, a memory and a host."""

    def __init__(self, dut, **memory):
        self.dut, self.given = dut, options()
        self.config = config_of(self.given["changes"])
        self.frusta = load(Path(self.given["folder"]))
        size = max(len(one.image.to_bytes()) for one in self.frusta)
        self.model = MemoryModel(self.config, bytes(size), base=BASE, seed=self.given["seed"], **memory)
        self.at_port = ModelAtPort(dut, self.model)
        self.host = Host(CocotbPort(dut, self.model), self.config, base=BASE)

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
        lives = ("scene", "phase", "frustum") if number == 0 else ("frustum",)
        counters = await bench.check(frustum, lives=lives)
        assert sum(one["intersection_won"] for one in counters) >= (frustum.hits.patch >= 0).sum()


def run(name, scene, changes, tests, *, cell, clusters, cycles, simulator="verilator", **frustum):
    changes = {**SMALL, "noc.columns": clusters, **changes}
    config = config_of(changes)
    folder = save(frusta(scene, config, cell=cell, **frustum), BUILD / "vectors" / f"engine-{name}")
    simulate(engine_text(config), MODULE, tests, simulator=simulator, name=f"engine-{name}", changes=changes,
             visible=("clk", "rst", "host__*", "axi__*"), folder=str(folder), cycles=cycles)


@pytest.mark.sim
@pytest.mark.parametrize("clusters", [1, 2])
def test_cornell(clusters):
    run(f"cornell-{clusters}", "cornell", {}, ("whole_frusta",), cell=0.5, clusters=clusters, points=(5, 1, 2),
        cycles=400_000)
