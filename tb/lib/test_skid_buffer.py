from amaranth.lib.data import StructLayout

from hw.lib.skid_buffer import SkidBuffer
from tb.lib.bench import Bench, Vectors

SHAPE = StructLayout({"number": 8, "inverted": 8})
ITEMS = [{"number": k, "inverted": ~k} for k in range(100)]


class TestSkidBuffer(Bench):
    """`tb.formal.test_stream_rules` proves that offers stay."""

    component, arguments, variants = SkidBuffer, {"shape": SHAPE, "bypass": False}, ({},)

    def vectors(self, config):
        return Vectors(inputs={"i": ITEMS}, expected={"o": ITEMS})


class TestBypass(TestSkidBuffer):
    """An item passes in its own cycle."""

    arguments = {"shape": SHAPE, "bypass": True}
