"""Stimulus of `golden.engine.icu.reciprocal`."""

from golden.engine.icu.plane_factor import GUARD
from golden.engine.icu.reciprocal import reciprocal
from golden.engine.lib.fixed import unsigned
from golden.engine.stimulus.block import Block, Field, hard_first

__all__ = ["BLOCK"]


def _bits(config):
    return config.numbers.mantissa_bits + GUARD


def _fields(config):
    bits = _bits(config)
    return [Field("mantissa", unsigned(bits, 0), "with its highest bit set")], [
        Field("inverse", unsigned(bits, 0), f"floor(2^{2 * bits - 1} / mantissa), its highest bit set")]


def _draw(random, count, config):
    low, high = 1 << (_bits(config) - 1), (1 << _bits(config)) - 1
    drawn = random.integers(low, high, count, endpoint=True)
    return {"mantissa": hard_first(drawn, [low, low + 1, high - 1, high, low + low // 2])}


def _expect(given, config):
    return {"inverse": reciprocal(given["mantissa"], _bits(config))}


BLOCK = Block(about="a mantissa", fields=_fields, draw=_draw, expect=_expect)
