from collections import deque

from hw.noc.link_receiver import LinkReceiver
from tb.lib.bench import Bench

CHANNELS, MESSAGES, DEPTH = 2, 2, 3


class TestLinkReceiver(Bench):
    component, variants = LinkReceiver, ({},)
    arguments = {"bits": 16, "channels": CHANNELS, "messages": MESSAGES, "depth": DEPTH}

    def model(self, config):
        """A queue for each kind, from its first channel; a credit returns in the cycle after its flit has left."""
        self.queues, credit = [deque() for _ in range(MESSAGES)], 0
        given = yield
        while True:
            outputs = {"o_credit": credit, **{f"o__{k}": queue[0] if queue else None
                                              for k, queue in enumerate(self.queues)}}
            credit = 0
            for k, queue in enumerate(self.queues):
                if queue and getattr(given, f"o__{k}"):
                    queue.popleft()
                    credit |= 1 << k * CHANNELS
            if given.i and given.i["channel"] % CHANNELS == 0:
                self.queues[given.i["channel"] // CHANNELS].append(given.i["flit"])
            given = yield outputs

    def drive(self, given, random):
        """No flit without a credit."""
        channel = given.i and given.i["channel"]
        if given.i and channel % CHANNELS == 0 and len(self.queues[channel // CHANNELS]) == DEPTH:
            given.i = None
