from collections import deque

import pytest

from hw.noc.input_queue import InputQueue
from tb.lib.bench import Bench

# By destination.
ROUTES = {0: 2, 1: 0, 2: 1, 3: 0}


class TestInputQueue(Bench):
    component, arguments, variants = InputQueue, {"bits": 8, "depth": 3, "routes": ROUTES}, ({},)
    is_single_cycle = False

    def model(self, config):
        """A packet's route is that of its first flit's destination."""
        self.flits, route, left = deque(), None, None
        given = yield
        while True:
            head = self.flits[0] if self.flits else None
            shown = head if self.is_single_cycle else left
            outputs = {"data": shown and shown["data"], "front": {
                **{name: head and head[name] for name in ("first", "last", "route")}, "valid": int(bool(head))}}
            left = None
            if given.pop:
                left = self.flits.popleft()
            if given.i:
                route = ROUTES[given.i["data"] % len(ROUTES)] if given.i["first"] else route
                self.flits.append(given.i | {"route": route})
            given = yield outputs

    def drive(self, given, random):
        """No flit without an entry, and none leaves an empty queue."""
        given.pop = bool(self.flits) and random.random() < 0.6
        if len(self.flits) == self.arguments["depth"]:
            given.i = None


class TestInOneCycle(TestInputQueue):
    arguments, is_single_cycle = {**TestInputQueue.arguments, "single_cycle": True}, True
    test_in_the_simulator = None


def test_there_are_routes():
    with pytest.raises(ValueError, match=r"^Routes must be of at least one destination, not \{\}$"):
        InputQueue(bits=8, depth=3, routes={})
