from amaranth.lib.data import StructLayout

from hw.lib.skid_buffer import SkidBuffer
from tb.lib.bench import Bench, Vectors
from tb.lib.runner import SIMULATORS

SHAPE = StructLayout({"number": 8, "inverted": 8})
ITEMS = [{"number": k, "inverted": ~k} for k in range(100)]


class TestSkidBuffer(Bench):
    """`tb.formal.lib.test_skid_buffer` proves its behaviour in all cycles."""

    variants, simulators, formula = ({},), SIMULATORS[1:], {"bypass": False}

    def make(self, config):
        return SkidBuffer(SHAPE)

    def vectors(self, config):
        return Vectors(inputs={"i": ITEMS}, expected={"o": ITEMS})


class TestBypass(TestSkidBuffer):
    """An item passes in its own cycle."""

    formula = {"bypass": True}

    def make(self, config):
        return SkidBuffer(SHAPE, bypass=True)
