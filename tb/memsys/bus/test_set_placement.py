import re

import numpy as np
import pytest

from golden.engine.memsys.bus.set_placement import SetPlacement as GoldenPlacement
from hw.memsys.bus.set_placement import SetPlacement
from tb.lib.bench import Bench, Vectors
from tb.memsys.placement_bench import TAGS, answers, check_starts, keys_of, requests

LINES, WAYS = 16, 4


def golden_of(lines, ways, direct):
    return GoldenPlacement(sets=lines, ways=1) if direct else GoldenPlacement(sets=lines // ways, ways=ways)


class TestSetPlacement(Bench):
    """Of four ways, or direct-mapped."""

    component, variants = SetPlacement, ({},)
    arguments = {"lines": LINES, "ways": WAYS, "key": 8, "tag": range(TAGS), "generation_bits": 2}

    def vectors(self, config):
        return self.drawn(config, 2)

    def drawn(self, config, seed):
        direct, keys = seed % 2, keys_of(LINES, seed)
        return Vectors(first={"i_start": [0]}, inputs={"i": requests(keys)}, ports={"direct": direct},
                       expected={"o": answers(golden_of(LINES, WAYS, direct), keys)})


@pytest.mark.parametrize(("lines", "ways", "direct", "generation_bits", "key"), [
    (4, 1, 0, 1, 8), (8, 2, 0, 2, 8), (16, 4, 1, 2, 8), (8, 2, 0, 2, 3), (8, 2, 0, 2, 2)])
def test_every_start_empties_all_lines(lines, ways, direct, generation_bits, key):
    """Tags run out after one start, or do not; keys of few bits all have lines of their own."""
    placement = SetPlacement(lines=lines, ways=ways, key=key, tag=range(TAGS), generation_bits=generation_bits)
    draw = np.random.default_rng(5)
    strings = [draw.integers(0, min(2 * lines, 1 << key), 40) for _ in range(6)]
    check_starts(placement, golden_of(lines, ways, direct), strings, direct=direct)


@pytest.mark.parametrize(("changes", "message"), [
    ({"ways": 3}, "Ways must be 1, 2 or 4, not 3"),
    ({"lines": 4, "ways": 4}, "Lines must be a power of two, at least 8, not 4"),
    ({"lines": 24}, "Lines must be a power of two, at least 4, not 24")])
def test_init_wrong(changes, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        SetPlacement(**{"lines": 8, "ways": 2, "key": 8, "tag": 4, "generation_bits": 2, **changes})
