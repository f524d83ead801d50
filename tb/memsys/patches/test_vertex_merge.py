from collections import deque

import pytest

from golden.engine.config import PRESETS
from hw.formats import VERTICES
from hw.memsys.patches.vertex_merge import PATCHES, VertexMerge
from tb.lib.bench import Bench
from tb.lib.grants import LongestWaiting

COUNT = 3


class TestVertexMerge(Bench):
    component, arguments, variants, span = VertexMerge, {"count": COUNT}, ({},), 300

    def model(self, config):
        """A patch is requested for when its last vertex has entered, and leaves without a gap."""
        rule, chosen, index = LongestWaiting(), None, 0
        queues, entered, whole = [deque() for _ in range(COUNT)], [0] * COUNT, [0] * COUNT
        given = yield
        while True:
            moves, requests = chosen is not None and given.o, [k for k in range(COUNT) if whole[k]]
            ends, oldest = moves and index == VERTICES - 1, rule.grant(requests, requests)
            outputs = {"o": None if chosen is None else queues[chosen][0], "left": 1 << chosen if ends else 0,
                       **{f"i__{k}": len(queues[k]) < VERTICES * PATCHES for k in range(COUNT)}}
            index = (index + moves) % VERTICES
            if moves:
                queues[chosen].popleft()
            if chosen is None or ends:
                chosen = oldest
                if oldest is not None:
                    rule.accept(oldest)
                    whole[oldest] -= 1
            for k, queue in enumerate(queues):
                vertex = getattr(given, f"i__{k}")
                if vertex is not None and outputs[f"i__{k}"]:
                    queue.append(vertex)
                    entered[k] += 1
                    whole[k] += entered[k] % VERTICES == 0
            given = yield outputs


def test_init_wrong():
    with pytest.raises(ValueError, match=r"^Count must be at least 1, not 0$"):
        VertexMerge(config=PRESETS["tiny"], count=0)
