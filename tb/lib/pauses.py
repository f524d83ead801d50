"""Pauses: in which cycles a source has nothing to give, or a sink does not take."""

import random
from collections.abc import Callable, Iterator
from itertools import cycle, repeat

__all__ = ["MATRIX", "PAUSES"]


def _random(seed):
    generator = random.Random(seed)
    while True:
        yield generator.random() < 0.4


def _bursts(seed):
    generator = random.Random(seed)
    while True:
        pauses = generator.random() < 0.5
        yield from repeat(pauses, generator.randint(1, 40))


def _stop(seed):
    yield from repeat(True, 300)
    yield from repeat(False)


# From a seed to whether each cycle is a pause.
PAUSES: dict[str, Callable[[int], Iterator[bool]]] = {
    "none": lambda seed: repeat(False),
    "alternating": lambda seed: cycle([False, True]),
    "random": _random,
    "bursts": _bursts,
    "stop": _stop,
}
# All pairs of pauses of a source and of a sink.
MATRIX = [(source, sink) for source in PAUSES for sink in PAUSES]
