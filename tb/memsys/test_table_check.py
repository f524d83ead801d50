"""Sizes: what the machine has bits for passes, and one more does not."""

import pytest
from amaranth.sim import Simulator

from golden.config import PRESETS
from golden.memory_map import GRID_RAY_BITS, GRID_SHAPE_BITS, GRID_SIDE_BITS
from hw.memsys.fault import Fault
from hw.memsys.image_layout import RegionNumber
from hw.memsys.table_check import TableCheck
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"]
SHAPE, SIDE, RAYS = 1 << GRID_SHAPE_BITS, 1 << GRID_SIDE_BITS, 1 << GRID_RAY_BITS


def faults(region, records):
    """Of each word; the tables that the records point into are as large as can be."""
    dut, found = TableCheck(config=CONFIG, tag=1), []
    words = [(number, word, low | high << 32) for number, record in enumerate(records)
             for word, (low, high) in enumerate(zip(record[::2], record[1::2], strict=True))]
    assert dut.latency == documented_latency(TableCheck, CONFIG)

    async def bench(ctx):
        ctx.set(dut.limit, (1 << 32) - 1)
        ctx.set(dut.o.ready, 1)
        for cycle in range(len(words) + dut.latency):
            ctx.set(dut.i.valid, cycle < len(words))
            if cycle < len(words):
                record, word, data = words[cycle]
                ctx.set(dut.i.payload.item, {"region": RegionNumber[region], "record": record, "word": word,
                                             "data": data})
            if ctx.get(dut.o.valid):
                found.append(Fault(ctx.get(dut.o.payload.fault)))
            await ctx.tick()

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    size = len(words) // len(records)
    return [found[size * k:size * (k + 1)] for k in range(len(records))]


def shell(rows, columns, first_ray):
    """Halves of a record of ``shells``, whose neighbours are large."""
    return [5, 7, 1 << 31, 1 << 31, 0, rows, 0, columns, first_ray, 0]


def test_grid_rays_of_shells():
    sizes = {(SIDE - 1, 1, 0): True, (SIDE, 1, 0): False, (1, SIDE - 1, 0): True, (1, SIDE, 0): False,
             (1 << 31, 0, 0): False, (0, 1 << 31, 0): False, (1024, RAYS >> 10, 0): True,
             (1024, RAYS >> 10, 1): False, (1023, RAYS >> 10, 1024): True, (1023, RAYS >> 10, 1025): False,
             (0, 0, RAYS): True, (0, 0, RAYS + 1): False, (1, 1, (1 << 32) - 1): False, (3, 5, 0): True}
    for size, found in zip(sizes, faults("SHELLS", [shell(*size) for size in sizes]), strict=True):
        assert found == [Fault.NONE] * 4 + [Fault.NONE if sizes[size] else Fault.SIZE], size


@pytest.mark.parametrize("axis", range(3))
def test_cells_along_an_axis(axis):
    for value, fault in (SHAPE - 1, Fault.NONE), (SHAPE, Fault.SIZE), (1 << 31, Fault.SIZE):
        shape = [1, 1, 1]
        shape[axis] = value
        (found,) = faults("CELL_GRID", [[1 << 31] * 4 + [*shape, 0]])
        wanted = [Fault.NONE] * 4
        wanted[2 + axis // 2] = fault
        assert found == wanted, (axis, value)
