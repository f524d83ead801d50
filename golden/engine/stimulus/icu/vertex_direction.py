"""Stimulus of `golden.engine.icu.vertex_direction`."""

import numpy as np

from golden.engine.icu.vertex_direction import vertex_direction
from golden.engine.lib.fixed import signed
from golden.engine.stimulus.block import Block, Field, hard_first

__all__ = ["BLOCK", "EXPONENT"]

EXPONENT = signed(5, 0)


def _fields(config):
    return [Field("vertex", config.numbers.vector, "R frame")], [
        Field("direction", config.numbers.vertex, "V'"), Field("exponent", EXPONENT, "V is V' 2^exponent, rounded")]


def _draw(random, count, config):
    high, low = config.numbers.vector.high, config.numbers.vector.low + 1
    size = 2.0 ** random.uniform(0, config.numbers.vector.width - 2, (count, 1))
    drawn = np.rint(random.uniform(-1, 1, (count, 3)) * size).astype(np.int64)
    # A magnitude with all bits set rounds up to another bit.
    full = (1 << config.numbers.vertex_bits + 1) - 1
    hard = [(0, 0, 0), (high, low, 0), (1, 0, 0), (0, -1, 0), (0, 0, high), (low, low, low), (full, 0, 1),
            (-full, full, full - 1), (full >> 1, 0, 0), (full + 1, 1, -1)]
    return {"vertex": hard_first(drawn, np.clip(hard, low, high))}


def _expect(given, config):
    direction, exponent = vertex_direction(given["vertex"], config.numbers)
    return {"direction": direction, "exponent": exponent}


BLOCK = Block(about="a vertex", fields=_fields, draw=_draw, expect=_expect)
