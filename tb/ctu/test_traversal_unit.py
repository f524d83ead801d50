# amaranth: UnusedElaboratable=no
"""The whole unit, from a subshell list to cells and hits, free running."""

import cocotb
import numpy as np
import pytest
from cocotb.triggers import RisingEdge

from golden.stimulus.ctu.records import traversal_record
from hw.ctu.traversal_unit import TraversalUnit
from tb.ctu.traversal_bench import Intersection, Place, SettlePort, Surroundings
from tb.icu.frustum_load import table_writes
from tb.lib.clocking import start
from tb.lib.configurations import config_of
from tb.lib.payload import pack, unpack
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.stream import Monitor, Source

MODULE = "tb.ctu.test_traversal_unit"
SMALL = {"ctu.lead": 2, "ctu.ray_slots": 64, "ctu.grid_row_bits": 6, "ctu.grid_column_bits": 8, "ctu.shell_bits": 3,
         "ctu.subshell_bits": 6, "icu.rays": 1024, "icu.side_bits": 6, "icu.generation_bits": 2}


class Host:
    """Who has the subshell list and the patches."""

    def __init__(self, dut, place, subshells, config):
        self._dut, self._place = dut, place
        shapes = {name: getattr(TraversalUnit(config=config), name).payload.shape()
                  for name in ("i_frustum", "i_entry", "i_vertex", "i_slack")}
        geometry = place.shelling.geometry
        listed = list(zip(subshells.patches.tolist(), subshells.shell.tolist(), strict=True))
        self._entries = [pack(shapes["i_entry"], {"patch": patch, "shell": shell}) for patch, shell in listed]
        self._beats = [[pack(shapes["i_vertex"], {"patch": patch, "surface": int(geometry.surface[patch]),
                                                  "vertex": vertex}) for vertex in geometry.vertices[patch].tolist()]
                       for patch in range(len(geometry))]
        # A cluster's list need not be the first one of the table.
        self._first = 3
        formats = place.formats
        place.frustum = pack(shapes["i_frustum"], {
            "traversal": unpack(formats.traversal_frustum, place.frustum), "last_shell": place.traversal.last_shell,
            "subshells": {"first": self._first, "count": len(listed), "patches": len(geometry)}})
        self._slack = [pack(shapes["i_slack"], one) for one in table_writes(place.record, config)]
        self.asked = []
        self._sources = {name: Source(dut, name) for name in ("i_entry", "i_vertex", "i_slack")}
        for name in ("o_entry", "o_patch"):
            getattr(dut, f"{name}__ready").value = 1
        self._monitors = [Monitor(dut, "o_entry", seen=self._entry), Monitor(dut, "o_patch", seen=self._patch)]
        self._waiting = {"i_entry": [], "i_vertex": []}
        self._tasks = [cocotb.start_soon(self._serve(name)) for name in self._waiting]

    def _entry(self, place):
        self._waiting["i_entry"].append(self._entries[place - self._first])

    def _patch(self, patch):
        self.asked.append(patch)
        self._waiting["i_vertex"] += self._beats[patch]

    async def _serve(self, name):
        edge, waiting = RisingEdge(self._dut.clk), self._waiting[name]
        while True:
            if waiting:
                await self._sources[name].send([waiting.pop(0)])
            else:
                await edge

    async def begin(self):
        """The table of the windows."""
        await self._sources["i_slack"].send(self._slack)

    def stop(self):
        """Answer nothing more."""
        for one in (*self._tasks, *self._monitors):
            (one.cancel if one in self._tasks else one.stop)()


@cocotb.test()
async def free_running(dut):
    """Each cluster: golden's cells and more, golden's hits, all subshells' patches; and subshells overlap."""
    given = options()
    await start(dut, cycles=given["cycles"])
    config = config_of(given["changes"])
    scene, cell, clusters = given["record"]
    record = traversal_record(scene, cell=cell, config=config, clusters=clusters)
    port = SettlePort(dut)
    for number, one in enumerate(record.sectors):
        place = Place(record.shelling, record.record, one.sector, config)
        around = Surroundings(dut, place, sink="random", stalls=0.2, seed=number, asks=False, port=port)
        host = Host(dut, place, one.subshells, config)
        tests = Intersection(around, delay=lambda random: random.integers(1, 200), seed=number)
        await host.begin()
        await around.begin()
        await around.until(lambda around=around: around.final)
        assert tests.idle, "the frustum is over while patches are tested"
        assert host.asked == one.subshells.patches.tolist()
        wanted = {cell for played in one.played for cell in played.stage.cells.tolist()}
        missing = wanted - {cell for cell, _ in around.cells}
        assert not missing, f"cluster {number}: cells {sorted(missing)[:5]} of golden's are missing"
        mine = one.sector.mask(record.record).ravel()
        different = np.intersect1d(tests.hits().differences(record.hits), np.flatnonzero(mine))
        assert not len(different), f"cluster {number}: {len(different)} rays hit something else"
        counters = unpack(TraversalUnit(config=config).counters.shape(), int(dut.counters.value))
        cocotb.log.info("%s", counters)
        assert counters["overlaps"], "subshells must overlap"
        for block in (around, host, tests):
            block.stop()


def run(record, changes, simulator, *, cycles, pipelines=1):
    simulate(TraversalUnit(config=config_of(changes), pipelines=pipelines), MODULE, ("free_running",),
             simulator=simulator, name=f"traversal-unit-{'-'.join(map(str, record))}-{simulator}", changes=changes,
             record=record, cycles=cycles)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_lobby(simulator):
    run(("lobby", 0.25, 1), SMALL, simulator, cycles=30_000)


LARGE = {**SMALL, "ctu.ray_slots": 4096, "ctu.shell_bits": 6, "ctu.grid_row_bits": 11, "ctu.grid_column_bits": 13,
         "ctu.subshell_bits": 11, "icu.rays": 4096}


@pytest.mark.nightly
@pytest.mark.parametrize(("scene", "clusters"), [("lobby", 2), ("room1627", 1)])
def test_scenes(scene, clusters):
    run((scene, 0.125, clusters), LARGE, "verilator", cycles=2_000_000, pipelines=2)
