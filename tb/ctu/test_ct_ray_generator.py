# amaranth: UnusedElaboratable=no

"""The ray generator asks for golden's grid rays, subshell by subshell and shell by shell, in their order."""

from itertools import pairwise

import cocotb
import pytest
from amaranth.sim import Simulator
from cocotb.triggers import ClockCycles, RisingEdge

from golden.stimulus.ctu.records import traversal_record
from hw.ctu.ct_ray_generator import CtRayGenerator
from hw.ctu.ctu_formats import GRID_GROUP
from tb.ctu.window_stages import CASES, SECTORS, RecordStages, WindowStages
from tb.lib.clocking import reset, start
from tb.lib.configurations import config_of
from tb.lib.coverage import Coverage
from tb.lib.no_x import assert_known
from tb.lib.payload import pack, unpack
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.stall_patterns import STALL_PAIRS, STALLS
from tb.lib.stream import Monitor, Sink, Source
from tb.lib.timing import documented_latency

MODULE = "tb.ctu.test_ct_ray_generator"
# Between the beginnings of short rows.
ROW_CYCLES = 5
# Frustum, sector and seed.
RUNS = [(kind, sector, 3 + sector) for kind, sectors in SECTORS.items() for sector in range(len(sectors))]


# No stage waits for those before it, but where a test says otherwise.
CONFIG = config_of({"ctu.run_ahead": 15})


def make(config):
    return CtRayGenerator(config=config)


SHAPE = make(CONFIG).signature.members["o"].signature.members["payload"].shape


def check(came, stages):
    """``came``: the payloads in their order; of groups each ray is looked at."""
    assert all(item["count"] <= GRID_GROUP for item in came)
    came = [{**item, "ray": item["ray"] + k, "column": item["column"] + k, "count": min(1, item["count"])}
            for item in came for k in range(max(1, item["count"]))]
    wanted = stages.requests
    for number, (got, item) in enumerate(zip(came, wanted, strict=False)):
        different = {name: (got[name], value) for name, value in item.items() if got[name] != value}
        flags = {name: got[name] for name in ("count", "last", "final") if got[name] != item.get(name, 0)}
        assert not different, f"request {number} of {len(wanted)}: (got, wanted) {different}"
        assert not flags, f"request {number} of {len(wanted)}: {flags} must not be"
    assert len(came) == len(wanted)


def run(component, stages, *, source="none", sink="none", over=0, run_ahead=15, barrier=False, seed=1):
    """What comes out in Amaranth's simulator, with the cycles, and the cycle of the first window.

    Parameters
    ----------
    over
        Cycles from the end of a stage at ``o`` to its end at ``i_over``.
    run_ahead, barrier
        The component's.
    """
    stalls, stops = STALLS[source](seed), STALLS[sink](seed + 1)
    came, cycles, first = [], [], []

    async def drive(ctx):
        for name, value in stages.ports.items():
            ctx.set(getattr(component, name), value)
        for write in stages.tables:
            ctx.set(component.i_table.payload, write)
            ctx.set(component.i_table.valid, 1)
            await ctx.tick()
        ctx.set(component.i_table.valid, 0)
        for item in stages.items:
            while next(stalls):
                ctx.set(component.i.valid, 0)
                await ctx.tick()
            ctx.set(component.i.payload, item)
            ctx.set(component.i.valid, 1)
            await ctx.tick().until(component.i.ready)
            ctx.set(component.i.valid, 0)

    async def take(ctx):
        cycle, ends, under_way, most, begun, overlap = 0, [], 0, 0, set(), False
        while not (came and came[-1]["final"]):
            ctx.set(component.o.ready, not next(stops))
            ctx.set(component.i_over.valid, bool(ends and ends[0] <= cycle))
            under_way -= bool(ends and ends[0] <= cycle)
            ends = ends[bool(ends and ends[0] <= cycle):]
            *_, taken, ready, valid, payload = await ctx.tick().sample(
                component.i.valid & component.i.ready, component.o.ready, component.o.valid,
                component.o.payload.as_value())
            cycle += 1
            assert cycle < 100_000, "the bench hangs"
            if taken:
                first.append(cycle)
            if ready and valid:
                item = unpack(SHAPE, payload)
                came.append(item)
                cycles.append(cycle)
                if not item["final"] and item["stage"] not in begun:
                    begun.add(item["stage"])
                    assert not barrier or item["shell"] > 2 or not under_way, "a subshell must wait for the one before"
                    overlap |= under_way > 0
                    under_way += 1
                    most = max(most, under_way)
                if item["last"]:
                    begun.discard(item["stage"])
                    ends.append(cycle + over)
        assert not barrier or overlap, "shells of a subshell must overlap"
        assert most <= run_ahead + 1, "a stage must not begin while too many are in flight"

    simulator = Simulator(component)
    simulator.add_clock(1e-8)
    simulator.add_testbench(drive)
    simulator.add_testbench(take)
    simulator.run()
    return came, cycles, first[0]


@pytest.mark.parametrize(("kind", "sector", "seed"), RUNS[1::2])
def test_rays_of_every_stage(kind, sector, seed):
    stages = WindowStages(kind, CONFIG, seed=seed, sector=sector, last_shell=5)
    came, _, _ = run(make(CONFIG), stages, source="random", sink="random" if seed % 2 else "bursts", over=20)
    check(came, stages)


@pytest.mark.parametrize(("scene", "cell", "clusters"), [
    ("cornell", 0.5, 2), pytest.param("lobby", 0.125, 2, marks=pytest.mark.nightly),
    pytest.param("room1627", 0.0625, 4, marks=pytest.mark.nightly)])
def test_rays_of_scenes(scene, cell, clusters):
    place = traversal_record(scene, cell=cell, config=config_of({"ctu.subshell_bits": 10}), clusters=clusters)
    for number in range(clusters):
        stages = RecordStages(place, number, CONFIG)
        asked = stages.asked()
        # Golden leaves out stages in which nothing may change.
        assert {stage: asked.get(stage, 0) for stage in stages.scanned} == stages.scanned
        came, _, _ = run(make(CONFIG), stages)
        check(came, stages)


@pytest.mark.parametrize("run_ahead", [0, 2])
def test_stages_wait_for_those_before(run_ahead):
    config = config_of({"ctu.run_ahead": run_ahead})
    stages = WindowStages("hemisphere", config, seed=9, sector=1, last_shell=4)
    came, _, _ = run(make(config), stages, over=60, run_ahead=run_ahead)
    check(came, stages)


def test_a_barrier_between_subshells():
    config = config_of({"ctu.run_ahead": 15, "ctu.subshell_barrier": 1})
    stages = WindowStages("hemisphere", config, seed=9, sector=1, last_shell=4)
    came, _, _ = run(make(config), stages, over=60, barrier=True)
    check(came, stages)


def test_a_group_per_cycle_after_the_latency():
    stages = WindowStages("hemisphere", CONFIG, seed=4, last_shell=6)
    stages.only(slice(0, 0))
    came, cycles, first = run(make(CONFIG), stages)
    check(came, stages)
    rays = stages.rays[2]
    assert cycles[0] - first == documented_latency(CtRayGenerator, CONFIG, rows=rays.rows, columns=rays.columns)
    by_row = {}
    for item, cycle in zip(came, cycles, strict=True):
        if item["count"]:
            by_row.setdefault(item["stage"], {}).setdefault(item["row"], []).append((cycle, item["count"]))
    assert len(by_row) == stages.last_shell - 1
    for rows in by_row.values():
        check_rate(list(rows.values()))


def check_rate(rows):
    """``rows``: by row of a stage, the cycles of its groups and how many rays each has."""
    for row in rows:
        assert row[-1][0] - row[0][0] + 1 == len(row), "groups of a row must follow each other without a gap"
        assert all(count == GRID_GROUP for _, count in row[:-1]), "all groups of a row but the last one must be full"
    for before, row in pairwise(rows):
        assert row[0][0] - before[0][0] <= max(len(before), ROW_CYCLES), "a row must begin when the last one has left"


def test_the_windows_hold_every_case():
    coverage = Coverage(CASES)
    for kind, sector, seed in RUNS:
        WindowStages(kind, CONFIG, seed=seed, sector=sector).hit(coverage)
    coverage.check()


class Bench:
    """The streams in a cocotb simulator; a stage is over some cycles after its last item."""

    def __init__(self, dut, stages, *, source="none", sink="none", seed=0):
        component = make(CONFIG)
        self.dut, self.stages = dut, stages
        self._shapes = {name: component.signature.members[name].signature.members["payload"].shape
                        for name in ("i", "i_table")}
        self._ports = {name: pack(component.signature.members[name].shape, value)
                       for name, value in stages.ports.items()}
        self.source = Source(dut, "i", stalls=STALLS[source](seed))
        self.table = Source(dut, "i_table")
        self.sink = Sink(dut, "o", stalls=STALLS[sink](seed + 50))
        dut.i_over__valid.value = 0
        self._over = cocotb.start_soon(self._end_stages(3 + 20 * (seed % 3)))

    async def _end_stages(self, after):
        edge, seen, waits = RisingEdge(self.dut.clk), 0, []
        while True:
            await edge
            waits = [time - 1 for time in waits]
            for item in self.sink.items[seen:]:
                waits += [after] * unpack(SHAPE, item)["last"]
            seen = len(self.sink.items)
            over = bool(waits and waits[0] <= 0)
            self.dut.i_over__valid.value = over
            waits = waits[over:]

    async def prepare(self):
        for name, value in self._ports.items():
            getattr(self.dut, name).value = value
        await self.table.send(pack(self._shapes["i_table"], write) for write in self.stages.tables)

    def send(self):
        return self.source.send([pack(self._shapes["i"], item) for item in self.stages.items])

    async def run(self):
        await self.send()
        while not (self.sink.items and unpack(SHAPE, self.sink.items[-1])["final"]):
            await RisingEdge(self.dut.clk)
        # Until the last stage is over.
        await ClockCycles(self.dut.clk, 1000)
        check([unpack(SHAPE, item) for item in self.sink.items], self.stages)

    def stop(self):
        self._over.cancel()
        self.sink.stop()
        for source in (self.source, self.table):
            source.valid.value = 0


@cocotb.test()
async def every_pair_of_stalls(dut):
    """The requests are the same under each pair of stall patterns, frustum after frustum."""
    await start(dut, cycles=600_000)
    for number, (source, sink) in enumerate(STALL_PAIRS):
        kind, sector, _ = RUNS[number % len(RUNS)]
        stages = WindowStages(kind, CONFIG, seed=options()["seed"] * 100 + number, sector=sector,
                              last_shell=3 + number % 3)
        bench = Bench(dut, stages, source=source, sink=sink, seed=number)
        await bench.prepare()
        if number == 0:
            assert_known(dut, ["i", "o"])
        await bench.run()
        bench.stop()


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing of what was in flight comes out after a reset."""
    await start(dut, cycles=200_000)
    for cut in (5, 40, 77, 200, 333):
        stages = WindowStages("hemisphere", CONFIG, seed=cut, sector=1, last_shell=4)
        bench = Bench(dut, stages)
        await bench.prepare()
        sending = cocotb.start_soon(bench.send())
        await ClockCycles(dut.clk, cut)
        sending.cancel()
        bench.stop()
        await reset(dut)
        bench = Bench(dut, stages)
        await bench.prepare()
        await bench.run()
        bench.stop()


@cocotb.test()
async def a_group_per_cycle(dut):
    """Without stalls the groups of a row follow each other without a gap."""
    await start(dut, cycles=50_000)
    stages = WindowStages("hemisphere", CONFIG, seed=4, last_shell=8)
    stages.only(slice(0, 0))
    bench = Bench(dut, stages)
    await bench.prepare()
    taken = Monitor(dut, "i")
    await bench.run()
    rays = stages.rays[2]
    assert bench.sink.cycles[0] - taken.cycles[0] == documented_latency(
        CtRayGenerator, CONFIG, rows=rays.rows, columns=rays.columns)
    rows = {}
    for item, cycle in zip((unpack(SHAPE, item) for item in bench.sink.items), bench.sink.cycles, strict=True):
        if item["count"] and item["shell"] == 8:
            rows.setdefault(item["row"], []).append((cycle, item["count"]))
    assert [sum(count for _, count in row) for row in rows.values()] == [stages.rays[8].columns] * stages.rays[8].rows
    check_rate(list(rows.values()))


@pytest.mark.parametrize("simulator", [SIMULATORS[0], pytest.param("icarus", marks=pytest.mark.nightly)])
def test_in_the_simulator(simulator):
    simulate(make(CONFIG), MODULE, ("every_pair_of_stalls", "reset_in_flight", "a_group_per_cycle"),
             simulator=simulator, name=f"ct-ray-generator-{simulator}")
