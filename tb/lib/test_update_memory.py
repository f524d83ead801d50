import random

import pytest

from hw.lib.update_memory import UpdateMemory
from tb.lib.block_bench import Vectors, check_block


def make(config, depth=4):
    # Odd operands add, others leave the row.
    return UpdateMemory(16, depth=depth, operand=16, tag=12, change=lambda old, operand: (old + operand, operand[0]))


def vectors(config, depth=4):
    """Rows that are hit again after every number of cycles."""
    generator, rows, items, expected = random.Random(5), [0] * depth, [], []
    for number in range(400):
        address, operand = generator.randrange(depth), generator.randrange(1 << 16)
        old, new = rows[address], (rows[address] + operand) % (1 << 16)
        items.append({"tag": number, "address": address, "operand": operand})
        expected.append({"tag": number, "address": address, "old": old, "new": new, "written": operand & 1})
        if operand & 1:
            rows[address] = new
    return Vectors(items=items, expected={"o": expected})


@pytest.mark.parametrize("depth", [2, 4, 7, 64])
def test_each_item_sees_all_before_it(depth):
    check_block(lambda config: make(config, depth), lambda config: vectors(config, depth), variants=[{}])
