"""Cell traversal meets golden's cells, ray by ray and in their order, at one cell per cycle."""

from collections import Counter, deque
from functools import partial

import cocotb
import numpy as np
import pytest
from cocotb.triggers import ClockCycles

from golden.engine.ctu.cell_traversal import INDEX_BITS
from golden.engine.ctu.grid_rays import FRACTION
from golden.engine.ctu.unit import global_directions
from golden.engine.stimulus.ctu.cell_traversal import BLOCK
from golden.engine.stimulus.ctu.records import traversal_record
from hw.ctu.cell_number import CellNumber
from hw.ctu.cell_steps import STAGES
from hw.ctu.cell_traversal import CellTraversal
from hw.ctu.traversal_start import TraversalStart
from tb.ctu.cell_rays import ONE, RAYS, long_rays, rays
from tb.ctu.traversal_bench import ClusterPart
from tb.lib.bench import Bench, Case
from tb.lib.clocking import start
from tb.lib.configurations import DEPTHS, config_of
from tb.lib.ports import Ports
from tb.lib.runner import SLOW_IN_ICARUS, options, simulate
from tb.lib.stages import Elastic, Stage, passage
from tb.lib.timing import documented_stages

TAG = 12
# Cycles after which all rays are through.
FOREVER = 1_000_000


def drawn_rays(config, seed):
    """As golden's stimulus draws them."""
    return rays(config, BLOCK.draw(np.random.default_rng(seed), RAYS, config))


def far_rays(config):
    """Shells that begin outside the range of a cell's index, where its bits are those of a cell of the grid."""
    side, step = 18, 1 << FRACTION
    direction = np.concatenate([np.eye(3, dtype=np.int64), -np.eye(3, dtype=np.int64)]) * step
    return rays(config, {"place": np.full(3, side // 2 * ONE + 1234), "shape": np.full(3, side), "direction": direction,
                         "begin": np.array(ONE << INDEX_BITS), "end": np.array((ONE << INDEX_BITS) + 100 * ONE)})


def check(came, given):
    """``came``: what came out, in its order."""
    items, expected = given.inputs["i"], given.about.cells
    cells, over = [[] for _ in items], [False] * len(items)
    for item in came:
        ray = item["tag"]
        assert not over[ray], f"ray {ray} continues after its last cell"
        if item["is_cell"]:
            cells[ray].append(item["cell"])
        over[ray] = bool(item["last"])
    assert all(over), f"ray {over.index(False)} has no last item"
    different = [ray for ray, (got, required) in enumerate(zip(cells, expected, strict=True)) if got != required]
    assert not different, (f"ray {different[0]} of {items[different[0]]}: {cells[different[0]]}, "
                           f"not {expected[different[0]]}")


class TestCellTraversal(Bench):
    component, arguments, simulators = CellTraversal, {"tag": TAG}, SLOW_IN_ICARUS
    cases = {"long": Case(long_rays, [{"icu.product_registers": depth} for depth in DEPTHS]),
             # Borders that are far away are met, once and again, and not early.
             **{f"along {along}": Case(partial(long_rays, side=64, along=along), [])
                for along in (4, 8, FRACTION)},
             "far": Case(far_rays, [{}], simulated=False),
             **{f"drawn {seed}": Case(partial(drawn_rays, seed=seed), [{}], simulated=False)
                for seed in (10, 11)}}
    # Until what came under other values of ports is through.
    idle_limit = 60
    cycles = 100_000

    def drawn(self, config, seed):
        return drawn_rays(config, seed)

    def is_over(self, given, came):
        last = self.shapes["o"]["last"].offset
        return sum(item >> last & 1 for item in came["o"]) == len(given.inputs["i"])

    def check(self, given, came):
        check(self.values("o", came), given)

    def predict(self, given, trace, component, config):
        """Rays start, go round, and their cells get numbers; the one behind all others comes when they are through."""
        stages = [*documented_stages(TraversalStart, config), Ring([*given.about.items, 0]), Elastic(1, 2),
                  *documented_stages(CellNumber, config)]
        accepted, left = passage(stages, [*trace.offered["i"], max(trace.offered["i"]) + FOREVER], trace.stalled["o"])
        return {"i": accepted[:-1], "o": left}


class Ring(Stage):
    """As many positions as a round has registers, each with the items that its ray has yet to give, one per round.

    All of them stall while the item at the end waits. A ray enters at a position whose ray has given its last item.
    """

    def __init__(self, counts):
        self._counts, self._cycle, self._left = iter(counts), 0, deque([0] * STAGES)

    def passes(self, offered, following):
        """See `Stage`."""
        while True:
            if not any(self._left):
                self._cycle = max(self._cycle, offered)
            left, cycle = self._left.pop(), self._cycle
            if left:
                cycle = following(cycle)
            enters = left <= 1 and cycle >= offered
            self._left.appendleft(next(self._counts) if enters else max(0, left - 1))
            self._cycle = cycle + 1
            if enters:
                return cycle


def test_cells_are_met_and_missed():
    """The drawn rays are worth their name."""
    lengths = [len(cells) for seed in range(10, 20) for cells in drawn_rays(config_of({}), seed).about.cells]
    assert {0, 1, 2, 3} <= set(lengths)


@cocotb.test()
async def rays_of_a_scene(dut):
    """Golden's grid rays of a frustum, as fast as they are taken: golden's cells, and a step in nearly every cycle."""
    await start(dut, cycles=100_000)
    given, config = options(), config_of({})
    ports = Ports(dut, CellTraversal(config=config, tag=TAG))
    record = traversal_record(given["scene"], cell=given["cell"], config=config)
    one = record.sectors[0]
    part = ClusterPart(record.shelling, record.record, one.sector, config)
    items = []
    for shell, numbers in part.sent(one.played):
        begin, end = part.traversal.borders(shell)
        direction = global_directions(part.rays[shell].direction.reshape(-1, 3)[numbers], record.record)
        items += [{"tag": shell, "direction": way, "begin": begin, "length": end - begin} for way in direction.tolist()]
    table = record.shelling.table
    ports["origin"], ports["shape"] = table.position(record.record.origin).tolist(), table.shape.tolist()
    await ports.send("i", items)
    await ClockCycles(dut.clk, 200)
    came, cycles = ports.came("o"), ports.sinks["o"].cycles
    assert sum(item["last"] for item in came) == len(items)
    assert len(came) == sum(played.stage.passes for played in one.played)
    got = Counter((item["tag"], item["cell"]) for item in came if item["is_cell"])
    # Rays go round together, so their cells interleave; the cells of each ray are in order in `test_ray_traversal`.
    assert got == Counter((played.stage.shell, cell) for played in one.played[1:]
                          for cell in played.stage.cells.tolist())
    busy = len(came) / (cycles[-1] - cycles[0] + 1)
    cocotb.log.info("%d rays, %d steps, busy %.3f", len(items), len(came), busy)
    assert busy >= given["busy"], f"a step in only {busy:.3f} of the cycles"


@pytest.mark.nightly
def test_busy_at_small_cells():
    simulate(CellTraversal(config=config_of({}), tag=TAG), __name__, scene="room1627", cell=0.0625, busy=0.95)
