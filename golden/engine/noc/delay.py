"""Latency of packets in an empty network."""

import numpy as np

__all__ = ["LINK", "zero_load_latency"]

# Cycles on a link or on the wires between a node and its router.
LINK = 1


def zero_load_latency(hops: np.ndarray | float, flits: np.ndarray | float = 1, *,
                      router_cycles: int = 2) -> np.ndarray | float:
    """Latency T = h (router_cycles + LINK) + router_cycles + 2 LINK + flits - 1, in cycles.

    From the cycle in which the source sends a packet until its last flit has arrived, with no other packet in flight:
    one router more than links, the wires at both ends, and the flits one after the other.

    Parameters
    ----------
    hops
        Links of the route.
    flits
        Flits of the packet.
    router_cycles
        Cycles in a router, 1 or 2.

    Source: Shen 1993, section 5.2.3.2 (wormhole routing).
    """
    return hops * (router_cycles + LINK) + router_cycles + 2 * LINK + flits - 1
