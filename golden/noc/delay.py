"""How long packets take through an empty network."""

import numpy as np

__all__ = ["LINK", "ROUTER", "zero_load_latency"]

# Cycles in a router, and on a link or on the wires between a node and its router.
ROUTER = 2
LINK = 1


def zero_load_latency(hops: np.ndarray | float, flits: np.ndarray | float = 1) -> np.ndarray | float:
    """T = h (ROUTER + LINK) + ROUTER + 2 LINK + flits - 1

    From the cycle in which a packet goes out until its last flit has come in, nothing else being on its way: one router
    more than links, the wires at both ends, and the flits one after the other.

    Parameters
    ----------
    hops
        Links of the way.
    flits
        Of the packet.

    Source: Shen 1993, section 5.2.3.2 (wormhole routing).
    """
    return hops * (ROUTER + LINK) + ROUTER + 2 * LINK + flits - 1
