import pytest
from amaranth.sim import Simulator
from hypothesis import given
from hypothesis import strategies as st

from hw.memsys.timeout import Timeout
from tb.lib.schedules import SETTINGS


def expected(cycles, bits):
    """In each cycle whether 2^bits cycles in a row have waited without progress, and none since had any."""
    since = 0
    for waits, moves in cycles:
        yield since >= 1 << bits
        since = since + 1 if waits and not moves else 0


@SETTINGS
@given(st.integers(1, 3), st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), max_size=60))
def test_expires_after_waits_without_progress(bits, drawn):
    cycles = [(waits != 0, moves == 0) for waits, moves in drawn]
    dut, found = Timeout(bits=bits), []

    async def bench(ctx):
        for waits, moves in cycles:
            ctx.set(dut.waits, waits)
            ctx.set(dut.moves, moves)
            found.append(bool(ctx.get(dut.expired)))
            await ctx.tick()

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    assert found == list(expected(cycles, bits))


def test_latency():
    assert [Timeout(bits=bits).latency for bits in (1, 5)] == [2, 32]


def test_bits_must_be_a_number_of_them():
    with pytest.raises(ValueError, match=r"^Bits must be at least 1, not 0$"):
        Timeout(bits=0)
    with pytest.raises(TypeError, match=r"^Bits must be"):
        Timeout(bits="4")
