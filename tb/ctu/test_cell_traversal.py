"""Cell traversal meets golden's cells, ray by ray and in their order, at one cell per cycle."""

from collections import Counter
from types import SimpleNamespace

import cocotb
import numpy as np
import pytest
from amaranth.sim import Simulator
from cocotb.triggers import ClockCycles, RisingEdge

from golden.ctu.cell_traversal import NEVER, POSITION_FRACTION
from golden.ctu.grid_rays import FRACTION
from golden.ctu.unit import global_directions
from golden.stimulus.ctu.cell_traversal import BLOCK
from golden.stimulus.ctu.records import traversal_record
from hw.ctu.cell_traversal import CellTraversal
from hw.ctu.ctu_formats import CtuFormats
from tb.ctu.traversal_bench import Place
from tb.lib.clocking import reset, start
from tb.lib.configurations import DEPTHS, config_of
from tb.lib.no_x import assert_known
from tb.lib.payload import pack, unpack
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.stall_patterns import STALL_PAIRS, STALLS
from tb.lib.stream import Monitor, Sink, Source
from tb.lib.timing import documented_latency

MODULE = "tb.ctu.test_cell_traversal"
TAG = 12
RAYS = 120
ONE = 1 << POSITION_FRACTION


class Case:
    """Rays of one shell, and the cells that golden meets with them."""

    def __init__(self, config, given):
        self.given = given
        self.expected = [[cell for cell in row if cell >= 0] for row in BLOCK.expect(given, config)["cells"].tolist()]
        self.items = [{"tag": number, "direction": direction, "begin": int(given["begin"]),
                       "length": int(given["end"] - given["begin"])}
                      for number, direction in enumerate(given["direction"].tolist())]
        self.ports = {"origin": given["place"].tolist(), "shape": given["shape"].tolist()}

    @classmethod
    def drawn(cls, config, seed):
        """As golden's stimulus draws them."""
        return cls(config, BLOCK.draw(np.random.default_rng(seed), RAYS, config))

    @classmethod
    def long(cls, config, *, side=18, along=0):
        """From the middle of a grid to its border; components are up to 2^``along`` times smaller than others."""
        random = np.random.default_rng(5)
        direction = random.normal(size=(RAYS, 3)) * 2.0 ** -random.uniform(0, along, (RAYS, 3))
        direction = np.rint(direction / np.linalg.norm(direction, axis=1)[:, None] * (1 << FRACTION)).astype(np.int64)
        return cls(config, {"place": (side // 2 - np.arange(3)) * ONE + 1234, "shape": side - np.arange(3),
                            "begin": np.array(0), "end": np.array(NEVER), "direction": direction})

    def check(self, came):
        """``came``: what came out, in its order."""
        cells, over = [[] for _ in self.items], [False] * len(self.items)
        for item in came:
            ray = item["tag"]
            assert not over[ray], f"ray {ray} goes on after its last cell"
            if item["is_cell"]:
                cells[ray].append(item["cell"])
            over[ray] = bool(item["last"])
        assert all(over), f"ray {over.index(False)} has no last item"
        different = [ray for ray, (got, wanted) in enumerate(zip(cells, self.expected, strict=True)) if got != wanted]
        assert not different, (f"ray {different[0]} of {self.items[different[0]]}: {cells[different[0]]}, "
                               f"not {self.expected[different[0]]}")


def run_case(component, case, *, source="none", sink="none", seed=1):
    """What comes out in Amaranth's simulator, and in which cycles: of the first transfer in, and of those out."""
    stalls, stops = STALLS[source](seed), STALLS[sink](seed + 1)
    came, cycles, first = [], [], []
    wanted = len(case.items)

    async def drive(ctx):
        for name, value in case.ports.items():
            ctx.set(getattr(component, name), value)
        for item in case.items:
            while next(stalls):
                ctx.set(component.i.valid, 0)
                await ctx.tick()
            ctx.set(component.i.payload, item)
            ctx.set(component.i.valid, 1)
            await ctx.tick().until(component.i.ready)
        ctx.set(component.i.valid, 0)

    async def take(ctx):
        cycle = 0
        while sum(item["last"] for item in came) < wanted:
            ctx.set(component.o.ready, not next(stops))
            *_, taken, ready, valid, payload = await ctx.tick().sample(
                component.i.valid & component.i.ready, component.o.ready, component.o.valid,
                component.o.payload.as_value())
            cycle += 1
            assert cycle < 100_000, "the bench hangs"
            if taken and not first:
                first.append(cycle)
            if ready and valid:
                came.append(unpack(component.o.payload.shape(), payload))
                cycles.append(cycle)

    simulator = Simulator(component)
    simulator.add_clock(1e-8)
    simulator.add_testbench(drive)
    simulator.add_testbench(take)
    simulator.run()
    return came, cycles, first[0]


@pytest.mark.parametrize(("source", "sink"), [("none", "none"), ("random", "bursts"), ("bursts", "random")])
@pytest.mark.parametrize("seed", range(2))
def test_cells_of_every_ray(source, sink, seed):
    config = config_of({})
    case = Case.drawn(config, 10 + seed)
    came, _, _ = run_case(CellTraversal(config=config, tag=TAG), case, source=source, sink=sink, seed=seed)
    case.check(came)


@pytest.mark.parametrize("registers", DEPTHS)
def test_a_cell_per_cycle_after_the_latency(registers):
    config = config_of({"icu.product_registers": registers})
    component, case = CellTraversal(config=config, tag=TAG), Case.long(config)
    came, cycles, first = run_case(component, case)
    case.check(came)
    assert component.latency == documented_latency(CellTraversal, config)
    assert cycles[0] - first == component.latency
    # Until the last rays leave gaps in the ring.
    full = cycles[:-100]
    assert len(full) > 1000
    assert full[-1] - full[0] + 1 == len(full), "a cell must come in each cycle"


def test_cells_are_met_and_missed():
    """The drawn rays are worth their name."""
    lengths = [len(cells) for seed in range(10, 20) for cells in Case.drawn(config_of({}), seed).expected]
    assert {0, 1, 2, 3} <= set(lengths)


class Bench:
    """The streams in a cocotb simulator."""

    def __init__(self, dut, **stalls):
        self.dut, self.config = dut, config_of({})
        component = CellTraversal(config=self.config, tag=TAG)
        self._in, self._out = (getattr(component, name).payload.shape() for name in "io")
        self.source = Source(dut, "i", stalls=stalls.get("source"))
        self.sink = Sink(dut, "o", stalls=stalls.get("sink"))

    async def prepare(self, case):
        formats = CtuFormats(self.config)
        self.dut.origin.value = sum(pack(formats.grid_coordinate, value) << k * formats.grid_coordinate.width
                                    for k, value in enumerate(case.ports["origin"]))
        self.dut.shape.value = sum(value << k * formats.grid_count.width
                                   for k, value in enumerate(case.ports["shape"]))
        # Until what came under the old ones is through.
        await ClockCycles(self.dut.clk, 60)

    async def run(self, case):
        came, start, over = [], len(self.sink.items), 0
        await self.source.send([pack(self._in, item) for item in case.items])
        while over < len(case.items):
            await RisingEdge(self.dut.clk)
            more = [unpack(self._out, item) for item in self.sink.items[start + len(came):]]
            over += sum(item["last"] for item in more)
            came += more
        case.check(came)


@cocotb.test()
async def every_pair_of_stalls(dut):
    """The cells are the same under each pair of stall patterns."""
    await start(dut, cycles=400_000)
    for number, (source, sink) in enumerate(STALL_PAIRS):
        bench = Bench(dut, source=STALLS[source](number), sink=STALLS[sink](number + 50))
        case = Case.drawn(bench.config, options()["seed"] * 100 + number)
        await bench.prepare(case)
        if number == 0:
            assert_known(dut, ["i", "o"])
        await bench.run(case)
        bench.sink.stop()


@cocotb.test()
async def rays_along_axes(dut):
    """Borders that are far away are met, once and again, and not early."""
    await start(dut, cycles=100_000)
    bench = Bench(dut)
    for along in (4, 8, FRACTION):
        case = Case.long(bench.config, side=64, along=along)
        await bench.prepare(case)
        await bench.run(case)


@cocotb.test()
async def reset_in_flight(dut):
    """Rays that are in flight when reset comes are gone."""
    await start(dut, cycles=100_000)
    for cut in (30, 77, 200):
        bench = Bench(dut)
        case = Case.long(bench.config)
        await bench.prepare(case)
        sending = cocotb.start_soon(bench.source.send([pack(bench._in, item) for item in case.items]))
        await ClockCycles(dut.clk, cut)
        sending.cancel()
        dut.i__valid.value = 0
        bench.sink.stop()
        await reset(dut)
        bench = Bench(dut)
        case = Case.drawn(bench.config, cut)
        await bench.prepare(case)
        await bench.run(case)
        bench.sink.stop()


@cocotb.test()
async def one_cell_per_cycle(dut):
    """Without stalls a cell comes in every cycle."""
    await start(dut, cycles=100_000)
    bench = Bench(dut)
    case = Case.long(bench.config)
    await bench.prepare(case)
    taken = Monitor(dut, "i")
    await bench.run(case)
    full = bench.sink.cycles[:-100]
    assert full[-1] - full[0] + 1 == len(full)
    assert full[0] - taken.cycles[0] == CellTraversal(config=bench.config, tag=TAG).latency


@cocotb.test()
async def rays_of_a_scene(dut):
    """Golden's grid rays of a frustum, as fast as they are taken: golden's cells, and a step in nearly every cycle."""
    await start(dut, cycles=100_000)
    given, bench = options(), Bench(dut)
    record = traversal_record(given["scene"], cell=given["cell"], config=bench.config)
    one = record.sectors[0]
    place = Place(record.shelling, record.record, one.sector, bench.config)
    items = []
    for shell, rays in place.sent(one.played):
        begin, end = place.traversal.borders(shell)
        direction = global_directions(place.rays[shell].direction.reshape(-1, 3)[rays], record.record)
        items += [{"tag": shell, "direction": way, "begin": begin, "length": end - begin} for way in direction.tolist()]
    table = record.shelling.table
    await bench.prepare(SimpleNamespace(ports={"origin": table.position(record.record.origin).tolist(),
                                               "shape": table.shape.tolist()}))
    await bench.source.send([pack(bench._in, item) for item in items])
    await ClockCycles(dut.clk, 200)
    came, cycles = [unpack(bench._out, item) for item in bench.sink.items], bench.sink.cycles
    assert sum(item["last"] for item in came) == len(items)
    assert len(came) == sum(played.stage.passes for played in one.played)
    got = Counter((item["tag"], item["cell"]) for item in came if item["is_cell"])
    assert got == Counter((played.stage.shell, cell) for played in one.played[1:]
                          for cell in played.stage.cells.tolist())
    busy = len(came) / (cycles[-1] - cycles[0] + 1)
    cocotb.log.info("%d rays, %d steps, busy %.3f", len(items), len(came), busy)
    assert busy >= given["busy"], f"a step in only {busy:.3f} of the cycles"


@pytest.mark.nightly
def test_busy_at_small_cells():
    simulate(CellTraversal(config=config_of({}), tag=TAG), MODULE, ("rays_of_a_scene",), name="cell-traversal-room1627",
             scene="room1627", cell=0.0625, busy=0.95)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_simulators(simulator):
    simulate(CellTraversal(config=config_of({}), tag=TAG), MODULE,
             ("every_pair_of_stalls", "rays_along_axes", "reset_in_flight", "one_cell_per_cycle"), simulator=simulator,
             name=f"cell-traversal-{simulator}")
