"""Requests of whole groups of beats; answers, and beats that are dropped.

`tb.memsys.results.test_result_writer` has the wider beats.
"""

from collections import deque

from hw.memsys.port.beat_writer import DEPTH, GROUP_BITS, REQUESTS, BeatWriter
from tb.lib.bench import Bench

GROUP = 1 << GROUP_BITS


class TestBeatWriter(Bench):
    component, variants, span = BeatWriter, [{"memory.data_bits": bits} for bits in (64, 128)], 600
    # The last parts fill the queues.
    chances = (*Bench.chances, (1, 0.05), (1, 0.2))

    def model(self, config):
        """A request is offered when its last beat has come; what was offered stays though beats are discarded."""
        size, beats, requests, outstanding = config.memory.beat_bytes, deque(), deque(), deque()
        top = 1 << config.memory.address_bits
        length = granted = self.sent = 0
        offered = False
        given = yield
        while True:
            discards, beat = given.discard, given.i
            accepts = len(beats) < DEPTH and len(requests) < REQUESTS
            offers = offered or (bool(requests) and len(outstanding) < REQUESTS and not discards)
            outputs = {
                "i": accepts, "idle": not (beats or requests or outstanding),
                "o_request": {"address": size * requests[0][0], "length": requests[0][1]} if offers else None,
                "o_data": {"data": beats[0]["data"], "strobe": sum(
                    15 << 4 * k for k in range(size // 4) if beats[0]["lanes"] >> k & 1)} if granted else None,
                "failed": bool(given.i_written and given.i_written["error"] and outstanding),
                "address": size * outstanding[0] % top if outstanding else None}
            takes, moves = beat is not None and accepts and not discards, offers and given.o_request
            drops = discards and not offered
            sends = bool(granted and given.o_data and beats[0]["ends"])
            if given.i_written:
                outstanding.popleft()
                self.sent -= 1
            if beats and (given.o_data if granted else drops):
                beats.popleft()
            if requests and (moves or drops):
                first, _ = requests.popleft()
                if moves:
                    outstanding.append(first)
            if takes:
                beats.append(beat)
                if beat["ends"]:
                    requests.append((beat["number"] - length, length))
            length = 0 if discards or (takes and beat["ends"]) else length + takes
            offered, granted, self.sent = offers and not moves, granted + moves - sends, self.sent + sends
            given = yield outputs

    def items(self, name, shape, random):
        """Beats of random requests, many at the end of memory, each within a group; half of the requests end there."""
        number = 0
        for item in super().items(name, shape, random):
            if name != "i":
                yield item
                continue
            ends = number % GROUP == GROUP - 1 or random.random() < 0.2
            yield item | {"number": number, "ends": int(ends)}
            end = (1 << shape["number"].width - 1) + random.randrange(-GROUP, GROUP)
            number = random.choice((random.getrandbits(20), end)) if ends and random.random() < 0.5 else number + 1

    def drive(self, given, random):
        """Answers of requests whose beats have left; beats are discarded now and then."""
        given.discard = random.random() < 0.02
        if not self.sent:
            given.i_written = None

