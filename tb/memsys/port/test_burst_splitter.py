from collections import deque

from hw.memsys.port.burst_splitter import BurstSplitter
from tb.lib.bench import Bench


class TestBurstSplitter(Bench):
    component, arguments, variants = BurstSplitter, {"tag": 3}, ({"memory.burst_beats": 4}, {"memory.burst_beats": 16})
    changes = {"memory.length_bits": 5}

    def model(self, config):
        """Beats of a request up to each multiple of the longest burst."""
        longest, bursts = config.memory.burst_beats, deque()
        given = yield
        while True:
            ready = not bursts or (given.o and len(bursts) == 1)
            outputs = {"i": ready, "o": bursts[0] if bursts else None}
            if bursts and given.o:
                bursts.popleft()
            if ready and given.i:
                first, last = given.i["first"], given.i["last"]
                while first <= last:
                    end = min(last, first | longest - 1)
                    bursts.append({"first": first, "length": end - first, "ends": int(end == last),
                                   "tag": given.i["tag"], "bad": given.i["bad"]})
                    first = end + 1
            given = yield outputs

    def items(self, name, shape, random):
        """Of one beat to as many as there may be; at most to the last beat of memory."""
        for item in super().items(name, shape, random):
            longest = 1 << self.config().memory.length_bits
            yield item | {"last": min(item["first"] + random.choice((0, random.randrange(longest), longest - 1)),
                                      (1 << shape["last"].shape) - 1)}
