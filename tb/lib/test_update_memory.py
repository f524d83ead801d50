import random

import pytest
from amaranth.hdl import Mux

from hw.lib.update_memory import UpdateMemory
from tb.lib.bench import Bench, Vectors


class TestUpdateMemory(Bench):
    """Each item sees all before it."""

    component, variants, splits, depth = UpdateMemory, ({},), False, 64

    @property
    def arguments(self):
        # Odd operands add or replace, others leave the row.
        return {"shape": 16, "depth": self.depth, "operand": 16, "tag": 12,
                "change": lambda _, old, operand: (Mux(operand[1], operand, old + operand)[:16], operand[0])}

    def vectors(self, config):
        """Rows that are hit again after every number of cycles; the first hit replaces what was there."""
        generator, rows, items, expected = random.Random(5), {}, [], []
        for number in range(400):
            # Of a deep memory a few rows, far from each other.
            address = generator.randrange(min(self.depth, 64)) * max(1, self.depth // 64)
            operand = generator.randrange(1 << 16) | (0 if address in rows else 3)
            old = rows.get(address)
            new = operand if operand & 2 else (old + operand) % (1 << 16)
            items.append({"tag": number, "address": address, "operand": operand})
            expected.append({"tag": number, "address": address, "old": old, "new": new, "written": operand & 1})
            if operand & 1:
                rows[address] = new
        return Vectors(inputs={"i": items}, expected={"o": expected})


@pytest.mark.parametrize("depth", [2, 4, 7, 4096])
def test_other_depths(depth):
    bench = TestUpdateMemory()
    bench.depth = depth
    bench.test_in_amaranth({})
