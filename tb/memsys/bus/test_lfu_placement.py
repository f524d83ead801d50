import re

import numpy as np
import pytest

from golden.engine.memsys.bus.lfu_placement import LfuPlacement as GoldenPlacement
from hw.memsys.bus.lfu_placement import LfuPlacement
from tb.lib.bench import Bench, Vectors
from tb.memsys.placement_bench import TAGS, answers, check_starts, keys_of, requests

LINES, COUNT_BITS = 8, 3


class TestLfuPlacement(Bench):
    component, variants = LfuPlacement, ({},)
    arguments = {"lines": LINES, "key": 8, "tag": range(TAGS), "count_bits": COUNT_BITS}

    def vectors(self, config):
        return self.drawn(config, 1)

    def drawn(self, config, seed):
        keys = keys_of(LINES, seed)
        return Vectors(first={"i_start": [0]}, inputs={"i": requests(keys)},
                       expected={"o": answers(GoldenPlacement(lines=LINES, count_bits=COUNT_BITS), keys)})

    def predict(self, given, trace, component, config):
        """A hit comes a cycle after the answer before it, a miss later; two requests wait for their answers."""
        more, accepted, left = component.latency_of_miss - component.latency, [], []
        for number, (offered, answer) in enumerate(zip(trace.offered["i"], given.expected["o"], strict=True)):
            free = left[number - 2] - component.latency + 2 if number > 1 else 0
            accepted.append(max(offered, accepted[-1] + 1 if accepted else 0, free))
            left.append(max(accepted[-1] + component.latency, left[-1] + 1 if left else 0)
                        + (0 if answer["hit"] else more))
        return {"i": accepted, "o": left}


@pytest.mark.parametrize(("lines", "count_bits"), [(2, 2), (4, 3), (16, 4)])
def test_every_start_empties_all_lines(lines, count_bits):
    placement, draw = LfuPlacement(lines=lines, key=8, tag=range(TAGS), count_bits=count_bits), np.random.default_rng(5)
    strings = [np.minimum(draw.geometric(1 / lines, 80), 255) for _ in range(2)]
    check_starts(placement, GoldenPlacement(lines=lines, count_bits=count_bits), strings, miss=count_bits + 5)


@pytest.mark.parametrize(("changes", "message"), [
    ({"lines": 128}, "Lines must be a power of two, from 2 to 64, not 128"),
    ({"lines": 12}, "Lines must be a power of two, from 2 to 64, not 12"),
    ({"count_bits": 0}, "Count bits must be at least 1, not 0")])
def test_init_wrong(changes, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        LfuPlacement(**{"lines": 8, "key": 8, "tag": 4, "count_bits": 3, **changes})
