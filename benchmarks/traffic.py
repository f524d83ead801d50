"""Traffic of a network, and what is measured of it: the definitions of the literature, as BookSim 2 has them.

*Offered load*: flits that a node makes per cycle, in packets at random times (Bernoulli), whether the network takes
them or not; sources queue without limit. *Latency* of a packet: from the cycle in which it is made until its last flit
has arrived, with the time in the source's queue. *Accepted load*: flits that arrive, per node and cycle.

A run warms up, then measures, then drains: latency is that of the packets made while it measures, all of which must
arrive; accepted load is what arrives while it measures. Traffic goes on to the end, so that the last packets measured
meet the same as the first.

A network is *saturated* at a load at which packets that were measured have not arrived when the drain is over, or the
mean latency is three times that at low load or more.
"""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError
from golden.engine.noc.network import NEVER, Arrivals, Network, Packets
from golden.engine.noc.routing import Routing
from golden.engine.noc.topology import Topology

__all__ = ["PATTERNS", "SATURATED", "Measurement", "Window", "bernoulli", "bound", "destinations", "hot_node",
           "measure", "pattern"]

PATTERNS = ("uniform", "transpose", "hotspot", "neighbour")
# The share of all packets that go to the hot node whatever their pattern.
HOT = 0.1
# Times the latency at low load.
SATURATED = 3


@dataclass(frozen=True, kw_only=True)
class Window:
    """Cycles of the three parts of a run."""

    warm_up: int
    measured: int
    drain: int

    @property
    def cycles(self) -> int:
        """All of them."""
        return self.warm_up + self.measured + self.drain


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """What a run showed.

    Parameters
    ----------
    accepted
        Flits per node and cycle that arrived while it measured.
    latency
        Mean latency of the measured packets, in cycles; infinite if one of them did not arrive.
    """

    accepted: float
    latency: float


def hot_node(topology: Topology) -> int:
    """The node behind the middle: 10 of a 4 x 4 network, 36 of 8 x 8."""
    return topology.rows // 2 * topology.columns + topology.columns // 2


def pattern(name: str, topology: Topology) -> np.ndarray:
    """To which nodes each node sends: N x N, rows of probabilities.

    *Uniform*: to all nodes, itself included; *transpose*: (column, row) to (row, column), where the network is no
    square to the node of that number if nodes are counted column by column; *hotspot*: uniform, but for a tenth of all
    packets, which go to `hot_node`; *neighbour*: to the node one column and one row further, around the borders.

    Raises
    ------
    InputError
        Another name.
    """
    nodes = topology.nodes
    column, row = topology.coordinates.T
    uniform = np.full((nodes, nodes), 1 / nodes)
    if name == "uniform":
        return uniform
    if name == "hotspot":
        hot = np.eye(nodes)[[hot_node(topology)] * nodes]
        return (1 - HOT) * uniform + HOT * hot
    if name == "transpose":
        return np.eye(nodes)[column * topology.rows + row]
    if name == "neighbour":
        return np.eye(nodes)[(row + 1) % topology.rows * topology.columns + (column + 1) % topology.columns]
    raise InputError(f"network: Pattern must be one of {', '.join(PATTERNS)}, not {name!r}")


def bound(routing: Routing, probabilities: np.ndarray) -> float:
    """The offered load at which the first link or node has a flit in each cycle."""
    nodes = routing.topology.nodes
    load = np.zeros((nodes, len(routing.topology.ports)))
    for source, destination in np.argwhere(probabilities):
        for node, output, _ in routing.path(source, destination):
            load[node, output] += probabilities[source, destination]
    return float(1 / max(1, load.max(), probabilities.sum(axis=0).max()))


def destinations(random: np.random.Generator, probabilities: np.ndarray, source: np.ndarray) -> np.ndarray:
    """Where each packet of the sources goes: the first node up to which the probabilities sum to more than a number."""
    below = np.cumsum(probabilities, axis=1)[source]
    chosen = (random.random((len(source), 1)) * below[:, -1:] >= below).sum(axis=1)
    return np.minimum(chosen, len(probabilities) - 1)


def bernoulli(probabilities: np.ndarray, *, load: float, length: int, cycles: int, seed: int) -> Packets:
    """Packets of ``length`` flits, made by each node in each cycle with probability ``load`` / ``length``.

    Parameters
    ----------
    probabilities
        See `pattern`.
    """
    random = np.random.default_rng(seed)
    nodes = len(probabilities)
    made, source = np.nonzero(random.random((cycles, nodes)) < load / length)
    return Packets(source=source, destination=destinations(random, probabilities, source),
                   length=np.full(len(source), length), made=made, message=np.zeros(len(source), dtype=np.int64))


def measure(routing: Routing, probabilities: np.ndarray, *, loads, length: int, buffer_flits: int, window: Window,
            seed: int) -> list[Measurement]:
    """Run a network once for each offered load, side by side.

    Parameters
    ----------
    routing, buffer_flits
        The network.
    probabilities, length
        See `bernoulli`.
    """
    nodes = routing.topology.nodes
    runs = [bernoulli(probabilities, load=load, length=length, cycles=window.cycles, seed=seed + number)
            for number, load in enumerate(loads)]
    together = Packets(
        source=np.concatenate([run.source + number * nodes for number, run in enumerate(runs)]),
        **{name: np.concatenate([getattr(run, name) for run in runs])
           for name in ("destination", "length", "made", "message")})
    arrivals = Network(routing, buffer_flits=buffer_flits, copies=len(runs)).run(together, cycles=window.cycles)
    return [observed(together, arrivals, window, np.arange(number * nodes, (number + 1) * nodes))
            for number in range(len(runs))]


def observed(packets: Packets, arrivals: Arrivals, window: Window, nodes: np.ndarray) -> Measurement:
    """What a run showed of the packets that ``nodes`` made."""
    begin, end = window.warm_up, window.warm_up + window.measured
    ours = np.isin(packets.source, nodes)
    flits = arrivals.taken[ours[arrivals.packet]]
    counted = ours & (packets.made >= begin) & (packets.made < end)
    last = np.cumsum(packets.length) - 1
    taken = arrivals.taken[last[counted]]
    latency = taken - packets.made[counted]
    arrived = len(latency) > 0 and (taken != NEVER).all()
    return Measurement(accepted=float(((flits >= begin) & (flits < end)).sum() / (len(nodes) * window.measured)),
                       latency=float(latency.mean()) if arrived else np.inf)
