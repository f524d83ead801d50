import random

import pytest

from hw.lib.update_memory import UpdateMemory
from tb.lib.bench import Bench, Vectors


class UpdateMemoryBench(Bench):
    component, variants = UpdateMemory, ({},)

    def __init__(self, depth):
        # Odd operands add, others leave the row.
        self._depth, self.arguments = depth, {"shape": 16, "depth": depth, "operand": 16, "tag": 12,
                                              "change": lambda old, operand: (old + operand, operand[0])}

    def vectors(self, config):
        """Rows that are hit again after every number of cycles."""
        generator, rows, items, expected = random.Random(5), [0] * self._depth, [], []
        for number in range(400):
            # Of a deep memory a few rows, far from each other.
            address = generator.randrange(min(self._depth, 64)) * max(1, self._depth // 64)
            operand = generator.randrange(1 << 16)
            old, new = rows[address], (rows[address] + operand) % (1 << 16)
            items.append({"tag": number, "address": address, "operand": operand})
            expected.append({"tag": number, "address": address, "old": old, "new": new, "written": operand & 1})
            if operand & 1:
                rows[address] = new
        return Vectors(inputs={"i": items}, expected={"o": expected})


@pytest.mark.parametrize("depth", [2, 4, 7, 64, 4096])
def test_each_item_sees_all_before_it(depth):
    UpdateMemoryBench(depth).test_in_amaranth({})
