import pytest
from amaranth.lib.data import StructLayout

from hw.lib.skid_buffer import SkidBuffer
from tb.lib.block_bench import Vectors, check_in_simulator
from tb.lib.runner import SIMULATORS

SHAPE = StructLayout({"number": 8, "inverted": 8})
ITEMS = [{"number": k, "inverted": ~k} for k in range(100)]


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("skid_buffer", lambda config: SkidBuffer(SHAPE),
                       lambda config: Vectors(items=ITEMS, expected={"o": ITEMS}), simulator=simulator)
