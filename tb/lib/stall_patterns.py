"""Stall patterns: in which cycles a source offers nothing, or a sink is not ready."""

import random
from collections.abc import Callable, Iterator
from itertools import cycle, repeat

import cocotb

__all__ = ["FEW_PAIRS", "STALLS", "STALL_PAIRS", "spaced", "stall_pairs"]


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
# Each pattern with two others at either end, for simulators that are slow.
FEW_PAIRS = [(source, [*STALLS][(number + by) % len(STALLS)]) for by in (1, 2) for number, source in enumerate(STALLS)]


def stall_pairs() -> list[tuple[str, str]]:
    """The pairs for a testbench of cocotb: in Verilator all, in others `FEW_PAIRS`."""
    return STALL_PAIRS if cocotb.SIM_NAME == "Verilator" else FEW_PAIRS


def spaced(pattern: Iterator[bool], interval: int) -> Iterator[bool]:
    """A source's pattern with at least ``interval`` cycles from an item to the next one."""
    for stalls in pattern:
        yield stalls
        yield from repeat(True, interval - 1)
