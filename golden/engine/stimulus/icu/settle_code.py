"""Stimulus of `golden.engine.icu.settle_code`."""

from golden.engine.icu.settle_code import settle_code, settle_floor, settle_threshold
from golden.engine.lib.fixed import unsigned
from golden.engine.stimulus.block import Block, Field, hard_first

__all__ = ["BLOCK"]


def _fields(config):
    return [Field("inverse", config.numbers.inverse, "1/t of a ray's best hit, or the bound of a patch")], [
        Field("code", config.icu.settle, "of a ray"),
        Field("floor", config.numbers.inverse, "least 1/t of a ray with the code"),
        Field("threshold", unsigned(config.icu.settle_bits + 1, 0), "the patch may improve a ray with a smaller code")]


def _draw(random, count, config):
    high = config.numbers.inverse.high
    drawn = random.integers(0, high, count, endpoint=True)
    edge = (config.numbers.inverse_bias - 1) << config.numbers.fraction_bits
    return {"inverse": hard_first(drawn, [0, 1, high, edge - 1, edge, edge + 1])}


def _expect(given, config):
    code = settle_code(given["inverse"], config)
    return {"code": code, "floor": settle_floor(code, config), "threshold": settle_threshold(given["inverse"], config)}


BLOCK = Block(about="an inverse distance", fields=_fields, draw=_draw, expect=_expect)
