"""Stimulus of `golden.engine.memsys.patches.filter`."""

import numpy as np

from golden.engine.lib.fixed import unsigned
from golden.engine.memsys.patches.filter import Filter
from golden.engine.stimulus.block import FLAG, Block, Field

__all__ = ["BLOCK"]

COUNT = 32
NUMBER = unsigned(24, 0)


def _fields(config):
    return [Field("count", NUMBER, "size: numbers are below it", constant=True),
            Field("tag_bits", unsigned(4, 0), "width of a tag", constant=True),
            Field("clears", FLAG, "a new generation begins before the number"),
            Field("number", NUMBER, "of a cell or a patch")], [
        Field("passes", FLAG, "the number has not passed before in this generation"),
        Field("passed", NUMBER, "numbers passed in this generation")]


def _draw(random, count, config):
    # Two bits of tag, so that the generations wrap.
    return {"count": np.array(COUNT), "tag_bits": np.array(2), "clears": random.random(count) < 0.05,
            "number": np.where(random.random(count) < 0.2, COUNT - 1, random.integers(COUNT, size=count))}


def _expect(given, config):
    block, found = Filter(int(given["count"]), tag_bits=int(given["tag_bits"])), []
    for clears, number in zip(given["clears"], given["number"], strict=True):
        if clears:
            block.clear()
        found.append((len(block.first(np.array([number]))), block.passed))
    passes, passed = np.array(found).T
    return {"passes": passes, "passed": passed}


BLOCK = Block(about="a number, one after the other", fields=_fields, draw=_draw, expect=_expect)
