"""A product, bit by bit."""

import random

import pytest

from hw.memsys.load.serial_product import SerialProduct
from tb.lib.bench import Bench, Vectors
from tb.lib.stages import Elastic


class TestSerialProduct(Bench):
    component, arguments, variants = SerialProduct, {"a": 9, "b": 5, "addend": 12}, ({},)

    def vectors(self, config):
        draw = random.Random(1)
        operands = [(511, 31, 4095), (0, 0, 0), (511, 0, 7), (3, 16, 0)] + [
            (draw.randrange(512), draw.randrange(32), draw.randrange(4096)) for _ in range(96)]
        return Vectors(inputs={"i": [{"a": a, "b": b, "addend": addend} for a, b, addend in operands]},
                       expected={"o": [a * b + addend for a, b, addend in operands]})

    def latency(self, component, config):
        """Of the longest factor."""
        assert component.latency == 1 + self.arguments["b"]
        return component.latency

    def stages(self, component, config):
        """A cycle, and one for each bit of b up to its highest 1; one product in flight."""
        return [Elastic((1 + item["b"].bit_length() for item in self.now.inputs["i"]), 1)]


@pytest.mark.parametrize("name", ["a", "b"])
def test_arguments_are_checked(name):
    with pytest.raises(ValueError, match=f"^{name.upper()} must be at least 1, not 0$"):
        SerialProduct(**{"a": 1, "b": 1, name: 0})
