"""The back end of cell traversal against golden's records: barrier order, free running, throughput."""

from collections import Counter
from itertools import product
from types import SimpleNamespace

import cocotb
import numpy as np
import pytest
from cocotb.triggers import ClockCycles

from golden.engine.cast.fixed_hits import read_out
from golden.engine.cast.shelling import Shelling, ShellingCounts
from golden.engine.ctu.sector import Sector
from golden.engine.icu.ray_memory import RayMemory
from golden.engine.stimulus.ctu.records import CELLS, SCENES, traversal_record
from hw.ctu.ray_traversal import RayTraversal
from hw.ctu.stage_count import NEAR_STAGE
from tb.ctu.stage_cells import StageCells, in_order
from tb.ctu.traversal_bench import FINAL, STAGES, ClusterPart, Intersection, SettlePort, Surroundings
from tb.golden.cast.frusta import random_frustum, speckled_frustum
from tb.lib.clocking import reset, start
from tb.lib.configurations import config_of
from tb.lib.drawn import drawn
from tb.lib.no_x import assert_known
from tb.lib.runner import SLOW_IN_ICARUS, options, simulate
from tb.lib.seed import NIGHTS
from tb.lib.stall_patterns import STALLS
from tb.lib.timing import documented_latency

# All that long runs see, so that they are fast.
# So many slots that each grid ray has one of its own in these scenes.
BARRIER = {"ctu.run_ahead": 0, "ctu.subshell_bits": 11, "ctu.ray_slots": 1024, "ctu.grid_row_bits": 6,
           "ctu.grid_column_bits": 8, "ctu.shell_bits": 3, "icu.rays": 1024, "icu.side_bits": 6,
           "icu.generation_bits": 2}

# One subshell, and no ray memory.
NO_LISTS = {"ctu.subshell_bits": 0}


def recorded(name, config):
    """A record of golden's."""
    scene, cell, clusters, screen = name
    return traversal_record(scene, cell=cell, config=config, clusters=clusters, pixels=(24, 16) if screen else None)


def random_record(seed, config):
    """The same of a random frustum that is hard to cast, in few cells, without subshells."""
    frustum = (random_frustum if seed % 3 else speckled_frustum)(seed)
    shelling = Shelling(frustum.geometry, config, cell=max(frustum.cell, 0.25), by_code=True)
    memory = RayMemory(len(frustum.record), config)
    tests, whole = shelling.tests(frustum.record, memory), Sector.whole(frustum.record)
    cluster, played = shelling.cluster(frustum.record, whole), []
    for one in cluster.schedule(None, tests.window):
        stage = cluster.explore(*one, memory.inverse)
        if stage is not None:
            played.append(SimpleNamespace(stage=stage))
            tests.run(stage, whole, ShellingCounts())
    return SimpleNamespace(
        shelling=shelling, record=frustum.record, hits=read_out(memory, frustum.record, tests.patches, config),
        sectors=[SimpleNamespace(sector=whole, subshells=None, played=played)])


def parts(name, config):
    """Of a record: each cluster's part and what golden did there."""
    record = recorded(name, config)
    return [(ClusterPart(record.shelling, record.record, one.sector, config), one.played) for one in record.sectors]


async def play(around, played):
    """The stages one after the other, each with golden's settle map when it begins."""
    around.port.words = around.part.words(played[0].codes)
    begins, requests = around.ports.taken("i_frustum"), 0
    await around.begin()
    assert around.cells == [(cell, NEAR_STAGE) for cell in played[0].stage.cells.tolist()]
    for number, (one, (shell, sent)) in enumerate(zip(played[1:], around.part.sent(played), strict=True)):
        around.port.words = around.part.words(one.codes)
        await around.swept()
        before, groups = len(around.cells), around.part.requests(number, one.stage.shell, one.stage.window)
        requests += sum(group.get("count", 0) for group in groups)
        await around.ports.send("i", groups)
        await around.ports.until(lambda number=number: around.over == number + 1)
        came = around.cells[before:]
        assert all(stage == number % STAGES for _, stage in came)
        got, expected = Counter(cell for cell, _ in came), Counter(one.stage.cells.tolist())
        assert got == expected, (f"subshell {one.stage.subshell}, shell {one.stage.shell}: {got - expected} came, "
                               f"{expected - got} did not")
        cells = [cell for cell, _ in came]
        assert all(in_order(around.part.cells(shell)[ray], cells) for ray in sent.tolist()), f"shell {shell}"
    assert not around.final
    await around.ports.send("i", [FINAL])
    await around.ports.until(lambda: around.final)
    await ClockCycles(around.ports.dut.clk, 3)
    assert not around.ports["closed"]
    counters = around.ports["counters"]
    expected = {"cells": len(around.cells), "requests": requests, "rays": sum(one.stage.grid_rays for one in played),
                "steps": sum(one.stage.passes for one in played), "deferrals": 0, "overlaps": 0,
                "cycles": around.ports.sinks["o"].cycles[-1] - begins.cycles[-1]}
    assert {name: counters[name] for name in expected} == expected


@cocotb.test()
async def cells_of_golden(dut):
    """In barrier order the same cells in the same shells of each subshell, as often as golden meets them."""
    await start(dut, cycles=options()["cycles"])
    given = options()
    config = config_of(given["changes"])
    stalls = [("random", "bursts"), ("none", "none"), ("bursts", "random")]
    port = SettlePort(dut)
    for number, (part, played) in enumerate(parts(given["record"], config)):
        assert sum(rays.rows * rays.columns for rays in part.rays.values()) <= config.ctu.ray_slots
        source, sink = stalls[number % len(stalls)]
        around = Surroundings(dut, RayTraversal(config=config), part, i=source, o=sink, misses=0.2, seed=number,
                              port=port)
        await ClockCycles(dut.clk, 3)
        assert_known(dut, [*around.ports.sources, *around.ports.sinks, "o_tile", "i_word"])
        await play(around, played)
        around.stop()


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing of before a reset comes out of the next frustum."""
    await start(dut, cycles=options()["cycles"])
    config = config_of(options()["changes"])
    (part, played), *_ = parts(options()["record"], config)
    for cut in (50, 150):
        around = Surroundings(dut, RayTraversal(config=config), part)
        around.port.words = part.words(played[0].codes)
        await around.begin()
        one = played[1].stage
        around.ports.begin("i", part.requests(0, one.shell, one.window))
        await ClockCycles(dut.clk, cut)
        around.stop()
        await reset(dut)
    around = Surroundings(dut, RayTraversal(config=config), part)
    await play(around, played)


# Times that a cell takes until its patches have been tested: none, long, and one cell much longer than others.
DELAYS = {"none": lambda random: 0, "long": lambda random: random.integers(20, 400),
          "stragglers": lambda random: 900 if random.random() < 0.05 else random.integers(1, 60)}


async def cast(around, tests, stages, depth):
    """All stages, as many of them in flight as the run-ahead depth allows."""
    await around.begin()
    for number, (_, shell, window) in enumerate(stages):
        await around.ports.until(lambda number=number: around.over + depth >= number)
        await around.ports.send("i", around.part.requests(number, shell, window))
    await around.ports.send("i", [FINAL])
    await around.ports.until(lambda: around.final)
    assert tests.idle, "the frustum is over while patches are tested"


@cocotb.test()
async def free_running(dut):
    """Whenever patches are tested: golden's cells, those that may survive for late settles, and golden's hits."""
    given = options()
    await start(dut, cycles=given["cycles"])
    config, ahead, overlaps, deferrals, excluded = config_of(given["changes"]), 0, 0, 0, 0
    port = SettlePort(dut)
    for number in range(given["runs"]):
        seed = given["seed"] * 1000 + number
        record = recorded(given["record"], config) if given["record"] else random_record(seed, config)
        one = record.sectors[seed % len(record.sectors)]
        part = ClusterPart(record.shelling, record.record, one.sector, config)
        stalls = list(STALLS)
        around = Surroundings(dut, RayTraversal(config=config), part, i=stalls[seed % 4], o=stalls[seed // 4 % 4],
                              seed=seed, port=port)
        tests = Intersection(around, delay=list(DELAYS.values())[seed % len(DELAYS)], seed=seed)
        stages = [stage for stage in part.cluster.schedule(one.subshells, tests.tests.window) if stage[1] > 1]
        await cast(around, tests, stages, config.ctu.run_ahead)
        expected = {cell for played in one.played for cell in played.stage.cells.tolist()}
        missing = expected - {cell for cell, _ in around.cells}
        assert not missing, f"run {seed}: cells {sorted(missing)[:5]} of golden's are missing"
        _, out = StageCells(around, stages).check()
        excluded += out
        mine = one.sector.mask(record.record).ravel()
        different = np.intersect1d(tests.hits().differences(record.hits), np.flatnonzero(mine))
        assert not len(different), f"run {seed}: {len(different)} rays hit something else"
        counters = around.ports["counters"]
        cocotb.log.info("run %d: %d cells, %s", seed, len(around.cells), counters)
        ahead, overlaps, deferrals = ahead + around.ahead, overlaps + counters["overlaps"], deferrals + counters[
            "deferrals"]
        around.stop()
        tests.stop()
    assert ahead, "stages must overlap"
    assert excluded, "settles must arrive in time for some grid rays"
    assert overlaps or not config.ctu.subshells or not given["record"], "subshells must overlap"
    assert deferrals or not config.ctu.subshells, "requests must be deferred while rays are in flight"


@cocotb.test()
async def a_step_per_cycle(dut):
    """Grid rays of a scene that all go on, stages without any left out: one of them steps in nearly every cycle."""
    given = options()
    await start(dut, cycles=given["cycles"])
    config = config_of(given["changes"])
    (part, played), *_ = parts(given["record"], config)
    around = Surroundings(dut, RayTraversal(config=config), part)
    around.port.words = part.words(played[0].codes * 0)
    await around.begin()
    for number, (shell, rays) in enumerate(stage for stage in part.sent(played) if len(stage[1])):
        await around.ports.until(lambda number=number: around.over + config.ctu.run_ahead >= number)
        await around.ports.send("i", part.requests(number, shell, None, rays))
    await around.ports.send("i", [FINAL])
    await around.ports.until(lambda: around.final)
    await ClockCycles(dut.clk, 3)
    counters = around.ports["counters"]
    busy = counters["steps"] / counters["cycles"]
    cocotb.log.info("busy %.3f, %.3f rays per cycle: %s", busy, counters["rays"] / counters["cycles"], counters)
    assert counters["rays"] == sum(one.stage.grid_rays for one in played)
    assert counters["steps"] == sum(one.stage.passes for one in played)
    assert busy >= given["busy"], f"a step in only {busy:.3f} of the cycles"


@pytest.mark.parametrize("lists", [True, pytest.param(False, marks=pytest.mark.nightly)])
@pytest.mark.parametrize("simulator", SLOW_IN_ICARUS)
def test_cells_of_golden(simulator, lists):
    run(("cornell", 0.5, 1, False), BARRIER if lists else {**BARRIER, **NO_LISTS}, simulator)


@pytest.mark.sim
def test_reset_in_flight():
    run(("cornell", 0.5, 2, False), BARRIER, "verilator", tests=("reset_in_flight", "cells_of_golden"))


# In the regressions the whole unit casts the same scene, with lists and without: `test_traversal_unit.py`.
@pytest.mark.nightly
@pytest.mark.parametrize("changes", [{"ctu.ray_slots": 64}, NO_LISTS])
def test_free_running(changes):
    run(("lobby", 0.25, 1, False), {**BARRIER, "ctu.run_ahead": 2, **changes}, "verilator",
        tests=("free_running",), pipelines=2, runs=1)


# So many slots that each grid ray has one of its own, in the largest of the scenes too.
LARGE = {**BARRIER, "ctu.ray_slots": 1 << 17, "ctu.shell_bits": 6, "ctu.grid_row_bits": 11, "ctu.grid_column_bits": 13,
         "icu.rays": 4096}


@pytest.mark.nightly
@pytest.mark.parametrize(("scene", "cell"), drawn([*product(SCENES, CELLS)], 4))
def test_cells_of_golden_in_scenes(scene, cell):
    run((scene, cell, 1, False), LARGE, "verilator", cycles=3_000_000)


@pytest.mark.nightly
def test_cells_of_golden_on_screens():
    run(("lobby", 0.125, 4, True), {**LARGE, "ctu.pyramid_levels": 3, "icu.product_registers": 3}, "verilator",
        cycles=3_000_000)


@pytest.mark.nightly
def test_many_free_runs():
    # So few slots that many rays share each.
    run(None, {**LARGE, "ctu.run_ahead": 2, "ctu.ray_slots": 16}, "verilator", tests=("free_running",), pipelines=2,
        runs=20 * NIGHTS, cycles=2_000_000 * NIGHTS)


@pytest.mark.nightly
@pytest.mark.parametrize("changes", [{"ctu.ray_slots": 4096}, NO_LISTS])
def test_busy_at_small_cells(changes):
    run(("room1627", 0.0625, 1, False), {**LARGE, **changes, "ctu.run_ahead": 15}, "verilator",
        tests=("a_step_per_cycle",), cycles=100_000, busy=0.95)


def run(record, changes, simulator, *, tests=("cells_of_golden",), pipelines=1, cycles=60_000, **given):
    config = config_of(changes)
    what = "-".join(map(str, (tests[0], *(record or ("random",)), config.ctu.subshells, simulator)))
    component = RayTraversal(config=config, pipelines=pipelines)
    assert component.latency == documented_latency(RayTraversal, config) + (pipelines > 1)
    simulate(component, __name__, tests, simulator=simulator, name=f"ray-traversal-{what}", changes=changes,
             record=record, cycles=cycles, **given)
