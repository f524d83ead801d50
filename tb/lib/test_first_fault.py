from itertools import chain

import pytest
from hypothesis import given
from hypothesis import strategies as st

from golden.engine.config import PRESETS
from hw.lib.first_fault import FirstFault
from hw.lib.payload import unpack
from hw.memsys.port.fault import Fault
from hw.memsys.port.memory_formats import MemoryFormats
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench

LAYOUT, COUNT = MemoryFormats(PRESETS["tiny"]).fault, 3
FAULTS = st.one_of(st.none(), st.tuples(st.sampled_from([fault for fault in Fault if fault is not Fault.NONE]),
                                        st.integers(0, 1000)))


URGENT = Fault.READ_TIMEOUT
BENCHES = {urgent: ScheduleBench(FirstFault(layout=LAYOUT, count=COUNT, urgent=urgent and urgent.value), watched=["o"])
           for urgent in (None, URGENT)}


@pytest.mark.parametrize("urgent", BENCHES)
@SETTINGS
@given(cycles=st.lists(st.tuples(st.tuples(*[FAULTS] * COUNT), st.sampled_from([0, 0, 0, 1])), max_size=20))
def test_the_first_one_stays_until_it_is_cleared_but_for_an_urgent_one(urgent, cycles):
    items, expected, kept = {f"i__{k}": [] for k in range(COUNT)}, [], (Fault.NONE, 0)
    idle = [0] * COUNT
    for faults, clear in cycles:
        expected.append(kept)
        for k, fault in enumerate(faults):
            if fault:
                items[f"i__{k}"].append((idle[k], {"code": fault[0].value, "address": fault[1]}))
            idle[k] = 0 if fault else idle[k] + 1
        if clear:
            kept = (Fault.NONE, 0)
        # One that comes in the cycle of a clear is not an earlier one.
        if kept[0] is Fault.NONE:
            kept = next((fault for fault in faults if fault), kept)
        if faults[0] and faults[0][0] is urgent:
            kept = faults[0]
    bench = BENCHES[urgent]
    bench.run(Schedule(items=items), clear=chain((clear for _, clear in cycles), [0]))
    found = [unpack(LAYOUT, bits) for bits in bench.history["o"]]
    assert [(Fault(one["code"]), one["address"]) for one in found[:len(cycles)]] == expected
    assert all((Fault(one["code"]), one["address"]) == kept for one in found[len(cycles):])


def test_count_must_be_a_number_of_inputs():
    with pytest.raises(ValueError, match=r"^Count must be at least 1, not 0$"):
        FirstFault(layout=LAYOUT, count=0)
    with pytest.raises(TypeError, match=r"^Count must be"):
        FirstFault(layout=LAYOUT, count=None)
