import pytest
from amaranth.sim import Simulator
from hypothesis import given
from hypothesis import strategies as st

from golden.config import PRESETS
from hw.lib.first_fault import FirstFault
from hw.memsys.fault import Fault
from hw.memsys.memory_formats import MemoryFormats
from tb.lib.schedules import SETTINGS

LAYOUT, COUNT = MemoryFormats(PRESETS["tiny"]).fault, 3
FAULTS = st.one_of(st.none(), st.tuples(st.sampled_from([fault for fault in Fault if fault is not Fault.NONE]),
                                        st.integers(0, 1000)))


@SETTINGS
@given(st.lists(st.tuples(st.tuples(*[FAULTS] * COUNT), st.sampled_from([0, 0, 0, 1])), max_size=20))
def test_the_first_one_stays_until_it_is_cleared(cycles):
    dut, found, expected, kept = FirstFault(layout=LAYOUT, count=COUNT), [], [], (Fault.NONE, 0)
    for faults, clear in cycles:
        expected.append(kept)
        if clear:
            kept = (Fault.NONE, 0)
        # One that comes in the cycle of a clear is not an earlier one.
        if kept[0] is Fault.NONE:
            kept = next((fault for fault in faults if fault), kept)

    async def bench(ctx):
        for faults, clear in cycles:
            ctx.set(dut.clear, clear)
            for source, fault in zip(dut.i, faults, strict=True):
                ctx.set(source.valid, fault is not None)
                code, address = fault or (Fault.NONE, 7)
                ctx.set(source.payload, {"code": code, "address": address})
            found.append((Fault(ctx.get(dut.o.code)), ctx.get(dut.o.address)))
            await ctx.tick()

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    assert found == expected


def test_count_must_be_a_number_of_inputs():
    with pytest.raises(ValueError, match=r"^Count must be at least 1, not 0$"):
        FirstFault(layout=LAYOUT, count=0)
    with pytest.raises(TypeError, match=r"^Count must be"):
        FirstFault(layout=LAYOUT, count=None)
