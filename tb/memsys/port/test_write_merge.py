"""Sources that share a port: whose request, data and answer."""

from collections import deque

import pytest

from golden.engine.config import PRESETS
from hw.memsys.port.write_merge import DEPTH, WriteMerge
from tb.lib.bench import Bench
from tb.lib.grants import RoundRobin

COUNT = 3


class TestWriteMerge(Bench):
    component, arguments, variants, span = WriteMerge, {"count": COUNT}, ({},), 400

    def model(self, config):
        """A request is granted a cycle before its transfer; its beats come when those of the one before have."""
        rule, granted, requests, order, beats, answers = RoundRobin(), None, deque(), deque(), deque(), deque()
        source, left = None, 0
        given = yield
        while True:
            wants = {k: item for k in range(COUNT) if (item := getattr(given, f"i_request__{k}")) is not None}
            is_free = max(len(requests), len(order)) + (granted is not None) < DEPTH
            following = rule.grant(wants, [k for k in wants if k != granted and is_free])
            beat, accepts = None if source is None else getattr(given, f"i_data__{source}"), len(beats) < 2
            outputs = {
                "o_request": requests[0] if requests else None, "o_data": beats[0] if beats else None,
                "i_written": len(answers) < 2, **{f"i_request__{k}": k == granted for k in range(COUNT)},
                **{f"i_data__{k}": k == source and accepts for k in range(COUNT)},
                **{f"o_written__{k}": {"error": answers[0]["error"]} if answers and answers[0]["tag"] == k else None
                   for k in range(COUNT)}}
            if requests and given.o_request:
                requests.popleft()
            if beats and given.o_data:
                beats.popleft()
            if answers and getattr(given, f"o_written__{answers[0]['tag']}"):
                answers.popleft()
            if given.i_written and outputs["i_written"]:
                answers.append(given.i_written)
            takes = beat is not None and accepts
            if takes:
                beats.append(beat)
            if source is None or (takes and left == 0):
                source, left = order.popleft() if order else (None, 0)
            else:
                left -= takes
            if granted is not None:
                requests.append(wants[granted] | {"tag": granted})
                order.append((granted, wants[granted]["length"]))
            if following is not None:
                rule.accept(following)
            granted = following
            given = yield outputs

    def items(self, name, shape, random):
        """Requests of few beats, and answers of a source."""
        for item in super().items(name, shape, random):
            if name.startswith("i_request"):
                yield item | {"length": random.choice((0, 0, 1, random.randrange(6)))}
            else:
                yield item | ({"tag": item["tag"] % COUNT} if name == "i_written" else {})


def test_init_wrong_count():
    with pytest.raises(ValueError, match=r"^Count must be at least 1, not 0$"):
        WriteMerge(config=PRESETS["tiny"], count=0)
