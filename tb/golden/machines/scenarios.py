"""Runs of the simulators of machines, whose numbers do not depend on compilation."""

import json
import sys

import numpy as np

from golden.machines.event_heap import event_heap, pop, push
from golden.noc.routing import route
from golden.noc.topology import Topology
from tb.golden.machines.packet_runs import run_packets
from tb.noc.packets import packets

__all__ = ["SCENARIOS"]


def _heap():
    """Times, kinds and subjects of events that schedule others."""
    heap, seen = event_heap(64), []
    for number in range(40):
        push(heap, number % 7, number % 3, number)
    for number in range(200):
        seen.append(pop(heap))
        time, kind, subject = seen[-1]
        push(heap, time + subject * 37 % 11, kind, subject * 5 % 97 + number % 2)
    return seen


def _network():
    """Packets of a loaded torus, with the cycles in which they entered, left and were accepted."""
    routing = route(Topology("torus", 4, 4), 2)
    given = packets(np.random.default_rng(5), routing.topology, "uniform", flits=400, load=0.6, longest=6)
    return run_packets(routing, given, buffer_flits=4, arbitration="age")


SCENARIOS = {"heap": _heap, "network": _network}

if __name__ == "__main__":
    json.dump({name: np.asarray(run()).tolist() for name, run in SCENARIOS.items()}, sys.stdout)
