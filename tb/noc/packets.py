"""Packets for benches: who sends to whom, how long and when."""

import numpy as np

from benchmarks import traffic
from golden.engine.noc.network import Packets
from golden.engine.noc.topology import Topology

__all__ = ["packets", "stalls"]


def packets(generator: np.random.Generator, topology: Topology, pattern: str, *, flits: int, load: float,
            longest: int = 16, messages: int = 1) -> Packets:
    """About so many flits in all, ``load`` of them per node and cycle, in packets of 1 to ``longest``."""
    mean = (1 + longest) / 2
    count = max(1, round(flits / mean))
    cycles = max(1, round(count * mean / load / topology.nodes))
    source = generator.integers(0, topology.nodes, count)
    return Packets(source=source,
                   destination=traffic.destinations(generator, traffic.pattern(pattern, topology), source),
                   length=generator.integers(1, longest + 1, count), made=np.sort(generator.integers(0, cycles, count)),
                   message=generator.integers(0, messages, count))


def stalls(generator: np.random.Generator, nodes: int, share: float) -> np.ndarray:
    """For each node in which of some cycles it stalls: now and then, and for long."""
    now, long = generator.random((2, 503, nodes)) < np.array([share, share / 40])[:, None, None]
    for _ in range(5):
        long |= np.roll(long, 1, axis=0) | np.roll(long, 7, axis=0) & (generator.random((503, 1)) < share)
    return now | long
