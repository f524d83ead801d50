import pytest
from amaranth.sim import Simulator
from hypothesis import given
from hypothesis import strategies as st

from golden.config import PRESETS
from hw.memsys.result_extents import ResultExtents
from hw.memsys.result_formats import ResultKind
from tb.lib.schedules import SETTINGS

CONFIG = PRESETS["tiny"]


def run(command, stalls=(0,)):
    """The extents of a command, and whether it was wrong."""
    dut, found = ResultExtents(config=CONFIG), []

    async def bench(ctx):
        ctx.set(dut.i.payload, command)
        ctx.set(dut.i.valid, 1)
        for cycle in range(400):
            ctx.set(dut.o.ready, cycle % (stalls[cycle % len(stalls)] + 1) == 0)
            if ctx.get(dut.o.valid) and ctx.get(dut.o.ready):
                found.append((ctx.get(dut.o.payload.address), ctx.get(dut.o.payload.length)))
            if ctx.get(dut.i.ready):
                found.append(bool(ctx.get(dut.wrong)))
                return
            await ctx.tick()
        raise AssertionError("the command was never accepted")

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    return found[:-1], found[-1]


def hits(columns, rows, section, address=4096, count=None):
    first_column, end_column, first_row, end_row = section
    return {"kind": ResultKind.HITS, "address": address, "count": columns * rows if count is None else count,
            "columns": columns, "total": 0, "section": {
                "first_column": first_column, "end_column": end_column, "first_row": first_row, "end_row": end_row}}


@SETTINGS
@given(st.integers(1, 9), st.integers(1, 5), st.data(), st.lists(st.integers(0, 3), min_size=1, max_size=4))
def test_each_row_of_a_section_is_an_extent(columns, rows, data, stalls):
    first, end = sorted(data.draw(st.lists(st.integers(0, columns), min_size=2, max_size=2, unique=True)))
    top, bottom = sorted(data.draw(st.lists(st.integers(0, rows), min_size=2, max_size=2, unique=True)))
    found, wrong = run(hits(columns, rows, (first, end, top, bottom)), stalls)
    assert not wrong
    assert found == [(4096 + 16 * (row * columns + first), 2 * (end - first) - 1) for row in range(top, bottom)]


@pytest.mark.parametrize("section", [(2, 2, 0, 1), (3, 2, 0, 1), (0, 1, 1, 1), (0, 1, 2, 1), (0, 5, 0, 1)], ids=str)
def test_no_part_of_the_frustum_is_wrong(section):
    assert run(hits(4, 2, section)) == ([], True)


@pytest.mark.parametrize(("count", "rows"), [(8, 2), (7, 1), (4, 1), (3, 0)])
def test_a_region_that_is_too_small_is_wrong(count, rows):
    """The rows that fit are offered before the error."""
    found, wrong = run(hits(4, 2, (0, 4, 0, 2), count=count))
    assert (len(found), wrong) == (rows, rows < 2)


@pytest.mark.parametrize(("count", "wrong"), [(0, True), (1, True), (2, False), (9, False)])
def test_sums_are_one_extent(count, wrong):
    """A region of sums has one more record than there are patches."""
    command = hits(1, 1, (0, 1, 0, 1), address=640, count=count) | {"kind": ResultKind.SUMS}
    assert run(command) == ([] if wrong else [(640, count - 1)], wrong)
