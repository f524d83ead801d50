"""Stimulus of `golden.engine.lib.cordic`."""

import numpy as np

from golden.engine.lib.cordic import circular, linear
from golden.engine.lib.fixed import signed, unsigned
from golden.engine.stimulus.block import Block, Field, hard_first

__all__ = ["BLOCK"]


def _fields(config):
    icu, numbers = config.icu, config.numbers
    # The second rotation of a vertex has the lengthened result of the first as its input.
    long = signed(numbers.vertex_bits + 2, icu.cordic_guard)
    return [Field("x", long, "circular: along"), Field("y", long, "circular: across"),
            Field("z", numbers.vertex, "linear: divisor, at least half of its range"),
            Field("w", numbers.vertex, "linear: dividend, at most the divisor in magnitude")], [
        Field("angle", unsigned(0, icu.angle_bits), "of (x, y) from the x axis, in turns"),
        Field("length", unsigned(numbers.vertex_bits + 4, icu.cordic_guard), "of (x, y) times the gain"),
        Field("quotient", signed(1, icu.cordic_stages), "w / z")]


def _draw(random, count, config):
    inputs, _ = _fields(config)
    low, high = inputs[0].format.low + 1, inputs[0].format.high
    size = 2.0 ** random.uniform(0, np.log2(high), (count, 1))
    turn = random.uniform(0, 2 * np.pi, count)
    pair = np.rint(np.stack([np.cos(turn), np.sin(turn)], axis=1) * size).astype(np.int64)
    hard_first(pair, [(0, 0), (high, 0), (low, 0), (0, high), (0, low), (high, high), (low, low), (low, high), (1, 0),
                      (-1, 0), (0, 1), (0, -1), (high, 1), (high, -1), (low, 1), (low, -1)])
    most = config.numbers.vertex.high
    divisor = random.integers(most // 2 + 1, most, count, endpoint=True)
    dividend = random.integers(-divisor, divisor, endpoint=True)
    quotient = np.stack([divisor, dividend], axis=1)
    hard_first(quotient, [(most, most), (most, -most), (most, 0), (most, 1), (most, -1), (most // 2 + 1, most // 2 + 1),
                          (most // 2 + 1, -most // 2)])
    return {"x": pair[:, 0], "y": pair[:, 1], "z": quotient[:, 0], "w": quotient[:, 1]}


def _expect(given, config):
    angle, length = circular(given["x"], given["y"], config.icu)
    return {"angle": angle, "length": length, "quotient": linear(given["w"], given["z"], config.icu)}


BLOCK = Block(about="a pair in circular mode and a pair in linear mode", fields=_fields, draw=_draw, expect=_expect)
