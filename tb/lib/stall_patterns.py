"""Stall patterns: in which cycles a source offers nothing, or a sink is not ready."""

import random
from collections.abc import Callable, Iterator
from itertools import cycle, repeat

__all__ = ["STALLS", "STALL_PAIRS"]


def _random(seed):
    generator = random.Random(seed)
    while True:
        yield generator.random() < 0.4


def _bursts(seed):
    generator = random.Random(seed)
    while True:
        stalled = generator.random() < 0.5
        yield from repeat(stalled, generator.randint(1, 40))


def _stop(seed):
    yield from repeat(True, 300)
    yield from repeat(False)


# By name, from a seed to whether the stream stalls in each cycle.
STALLS: dict[str, Callable[[int], Iterator[bool]]] = {
    "none": lambda seed: repeat(False),
    "alternating": lambda seed: cycle([False, True]),
    "random": _random,
    "bursts": _bursts,
    "stop": _stop,
}
# All pairs of patterns, one for the source and one for the sink.
STALL_PAIRS = [(source, sink) for source in STALLS for sink in STALLS]
