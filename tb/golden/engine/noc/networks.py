"""Networks of all topologies and shapes."""

import numpy as np

from golden.engine.noc.routing import classes_needed, route
from golden.engine.noc.topology import Topology

__all__ = ["networks", "starts"]

SHAPES = [(2, 1), (3, 3), (4, 2), (4, 4), (5, 3), (8, 8)]


def networks(name):
    """All shapes that a topology can have, with one and two channels per class."""
    for number, (columns, rows) in enumerate(SHAPES):
        if name == "hypercube" and columns * rows & columns * rows - 1:
            continue
        topology = Topology(name, columns, rows)
        yield number, route(topology, classes_needed(topology) * (1 + number % 2))


def starts(given):
    """The number of each packet's first flit."""
    return np.cumsum(given.length) - given.length
