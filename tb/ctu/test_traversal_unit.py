"""The whole unit, from a subshell list to cells and hits, free running."""

import cocotb
import numpy as np
import pytest
from cocotb.triggers import ClockCycles

from golden.engine.stimulus.ctu.records import traversal_record
from hw.ctu.subshell_generator import ListError
from hw.ctu.traversal_unit import TraversalUnit
from radiosity.flow.package.example.frustum_load import table_writes
from tb.ctu.stage_cells import StageCells
from tb.ctu.traversal_bench import ClusterPart, Intersection, SettlePort, Surroundings
from tb.lib.clocking import reset, start
from tb.lib.configurations import config_of
from tb.lib.drawn import drawn
from tb.lib.responder import Responder
from tb.lib.runner import SLOW_IN_ICARUS, options, simulate

# All that long runs see, so that they are fast.
SMALL = {"ctu.run_ahead": 2, "ctu.ray_slots": 64, "ctu.grid_row_bits": 6, "ctu.grid_column_bits": 8,
         "ctu.shell_bits": 3, "ctu.subshell_bits": 6, "icu.rays": 1024, "icu.side_bits": 6, "icu.generation_bits": 2}


# A cluster's list need not be the first one of the table.
FIRST = 3


def given_record(config):
    """The record that the options name."""
    scene, cell, clusters, screen = options()["record"]
    return traversal_record(scene, cell=cell, config=config, clusters=clusters, pixels=(24, 16) if screen else None)


class Cast:
    """A cluster's frustum: everything that stands around the unit.

    Parameters
    ----------
    listed
        Subshells that the frustum has, if not those of the list.
    """

    def __init__(self, dut, record, one, config, *, seed, port, listed=None):
        self._record, self._one, self._config = record, one, config
        self.part = part = ClusterPart(record.shelling, record.record, one.sector, config)
        count = len(one.subshells.patches)
        part.frustum = {"traversal": part.frustum, "last_shell": part.traversal.last_shell, "subshells": {
            "first": FIRST if count else 0, "count": count if listed is None else listed,
            "patches": len(part.shelling.geometry)}}
        self.around = Surroundings(dut, TraversalUnit(config=config), part, o="random", misses=0.2, seed=seed,
                                   port=port)
        self.ports = self.around.ports
        if config.ctu.subshells:
            self.ports.respond(Responder("o_entry", "i_entry", self._entry),
                               Responder("o_patch", "i_vertex", self._beats))
        self.tests = Intersection(self.around, delay=lambda random: random.integers(1, 200), seed=seed)

    def _entry(self, address):
        subshells = self._one.subshells
        return [{"patch": subshells.patches[address - FIRST], "shell": subshells.shell[address - FIRST]}]

    def _beats(self, patch):
        geometry = self.part.shelling.geometry
        return [{"patch": patch, "surface": geometry.surface[patch], "vertex": vertex}
                for vertex in geometry.vertices[patch].tolist()]

    @property
    def requested(self):
        """Patches of the list, in the order of their requests."""
        return self.ports.came("o_patch") if self._config.ctu.subshells else []

    async def begin(self):
        """Tables, frustum, near cells."""
        if self._config.ctu.subshells:
            await self.ports.send("i_slack", table_writes(self.part.record, self._config))
        await self.around.begin()

    async def check(self):
        """To the end: golden's cells, those that may survive for late settles, and golden's hits; the counters."""
        around, one = self.around, self._one
        await self.ports.until(lambda: around.final)
        assert self.tests.idle, "the frustum is over while patches are tested"
        assert self.requested == one.subshells.patches.tolist()
        expected = {cell for played in one.played for cell in played.stage.cells.tolist()}
        missing = expected - {cell for cell, _ in around.cells}
        assert not missing, f"cells {sorted(missing)[:5]} of golden's are missing"
        stages = [stage for stage in self.part.cluster.schedule(self._one.subshells, self.tests.tests.window)
                  if stage[1] > 1 and (stage[2] is None or stage[2][1] * stage[2][3])]
        undecided, excluded = StageCells(around, stages).check()
        cocotb.log.info("of the grid rays %d may survive for late settles, %d may not", undecided, excluded)
        assert excluded, "settles must arrive in time for some grid rays"
        mine = one.sector.mask(self._record.record).ravel()
        different = np.intersect1d(self.tests.hits().differences(self._record.hits), np.flatnonzero(mine))
        assert not len(different), f"{len(different)} rays hit something else"
        counters = self.ports["counters"]
        cocotb.log.info("%d cells of golden's, %d came: %s", len(expected), len(around.cells), counters)
        return counters

    def stop(self):
        """Nothing more."""
        for block in (self.around, self.tests):
            block.stop()


@cocotb.test()
async def free_running(dut):
    """Each cluster: golden's cells, golden's hits, all subshells' patches; and subshells overlap."""
    given = options()
    await start(dut, cycles=given["cycles"])
    config, port = config_of(given["changes"]), SettlePort(dut)
    record = given_record(config)
    for number, one in enumerate(record.sectors):
        cast = Cast(dut, record, one, config, seed=number, port=port)
        await cast.begin()
        counters = await cast.check()
        several = len({played.stage.subshell for played in one.played if played.stage.grid_rays}) > 1
        assert counters["overlaps"] or not several, "subshells must overlap"
        cast.stop()


@cocotb.test()
async def without_lists(dut):
    """Golden's hits; a list that is given all the same is an error, and the hits are the same."""
    given = options()
    await start(dut, cycles=given["cycles"])
    config, port = config_of(given["changes"]), SettlePort(dut)
    record = given_record(config)
    one = record.sectors[0]
    for count, error in (0, ListError.NONE), (1, ListError.LENGTH), (0, ListError.NONE):
        cast = Cast(dut, record, one, config, seed=count, port=port, listed=count)
        await cast.begin()
        await cast.check()
        assert cast.ports["error"] == error.value
        cast.stop()


@cocotb.test()
async def reset_in_flight(dut):
    """A frustum that reset cuts off, wherever it is, leaves nothing in the next one."""
    given = options()
    await start(dut, cycles=given["cycles"])
    config = config_of(given["changes"])
    record = given_record(config)
    one = record.sectors[0]
    for number, cut in enumerate((20, 300, 700, 1500)):
        port = SettlePort(dut)
        cast = Cast(dut, record, one, config, seed=number, port=port)
        await cast.begin()
        await ClockCycles(dut.clk, cut)
        cast.stop()
        port.stop()
        await reset(dut)
    port = SettlePort(dut)
    cast = Cast(dut, record, one, config, seed=9, port=port)
    await ClockCycles(dut.clk, 100)
    assert not cast.around.cells, "nothing may come before a frustum begins"
    assert not cast.requested
    await cast.begin()
    await cast.check()
    cast.stop()


def run(record, changes, simulator, *, cycles, tests=("free_running",), pipelines=1, **given):
    what = "-".join(map(str, (tests[0], *record)))
    component = TraversalUnit(config=config_of(changes), pipelines=pipelines)
    simulate(component, __name__, tests, simulator=simulator, name=f"traversal-unit-{what}-{simulator}",
             changes=changes, record=record, cycles=cycles, **given)


# Lists are in preset `thesis` alone, which the nightly casts.
@pytest.mark.parametrize("simulator", SLOW_IN_ICARUS)
def test_lobby(simulator):
    run(("lobby", 0.25, 1, False), SMALL, simulator, cycles=30_000, pipelines=2)


@pytest.mark.parametrize("simulator", SLOW_IN_ICARUS)
def test_without_lists(simulator):
    run(("lobby", 0.25, 1, False), SMALL | {"ctu.subshell_bits": 0}, simulator, cycles=30_000,
        tests=("without_lists",))


LARGE = {**SMALL, "ctu.ray_slots": 4096, "ctu.shell_bits": 6, "ctu.grid_row_bits": 11, "ctu.grid_column_bits": 13,
         "ctu.subshell_bits": 11, "icu.rays": 4096}


@pytest.mark.nightly
@pytest.mark.parametrize(("scene", "cell", "clusters", "screen"), drawn([
    ("cornell", 0.125, 1, False), ("lobby", 0.125, 2, False), ("room1627", 0.125, 1, False), ("lobby", 0.125, 2, True)],
    2))
def test_scenes(scene, cell, clusters, screen):
    run((scene, cell, clusters, screen), LARGE, "verilator", cycles=2_000_000, pipelines=2)


@pytest.mark.nightly
def test_reset_in_flight():
    run(("lobby", 0.25, 1, False), LARGE, "verilator", cycles=200_000, tests=("reset_in_flight",), pipelines=2)
