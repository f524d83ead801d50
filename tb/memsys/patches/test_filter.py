import re

import numpy as np
import pytest

from golden.engine.config import PRESETS
from golden.engine.memsys.patches.filter import Filter as GoldenFilter
from golden.engine.stimulus import block
from hw.memsys.patches.filter import Filter
from tb.lib.bench import Bench, Vectors
from tb.lib.schedules import ScheduleBench
from tb.lib.stages import Elastic, Expand
from tb.memsys.started import PAUSE, started

BITS, COUNT, LIMIT, WORD = 7, 64, 50, 4


def make(generation_bits=2, word_bits=WORD, count=COUNT):
    return Filter(bits=BITS, count=count, generation_bits=generation_bits, word_bits=word_bits)


def numbers(seed, size=120):
    """Some again at once, some later, some of one word, some that there are not."""
    random = np.random.default_rng(seed)
    drawn = np.choose(random.integers(3, size=size), [random.integers(COUNT, size=size),
                                                      random.integers(WORD, size=size),
                                                      random.integers(1 << BITS, size=size)])
    again = np.flatnonzero(random.random(size) < 0.3)[1:]
    drawn[again] = drawn[again - random.integers(1, 4, size=len(again)).clip(max=again)]
    return drawn


def passing(given):
    return GoldenFilter(LIMIT).first(given[given < LIMIT])


class TestFilter(Bench):
    variants = ({},)

    def make(self, config):
        return make()

    def vectors(self, config):
        return self.drawn(config, 1)

    def drawn(self, config, seed):
        # Begins with one that passes.
        given = np.concatenate([[7], numbers(seed)])
        expected = passing(given)
        return Vectors(first={"i_start": [0]}, inputs={"i": given.tolist()}, expected={"o": expected.tolist()},
                       ports={"limit": LIMIT}, after={"seen": len(given), "passed": len(expected)})

    def stages(self, component, config):
        """What does not pass takes a cycle at the end."""
        given = self.now.inputs["i"]
        passes = (int(number < LIMIT and number not in given[:k]) for k, number in enumerate(given))
        return [Elastic(component.latency, component.capacity), Expand(passes)]


def run(dut, generations, *, limit=LIMIT):
    """What passes, is dropped and is wrong of the numbers of some generations, and when what went in and out."""
    bench = ScheduleBench(dut, idle_limit=4 * PAUSE, watched=["dropped", "wrong", "number"])
    passes = bench.run(started([list(map(int, given)) for given in generations]), limit=limit)["o"]
    left = {cycle: (number, "passes") for cycle, number in zip(bench.cycles["o"], passes, strict=True)}
    dropped = {cycle: (number, "wrong" if wrong else "dropped") for cycle, (is_dropped, wrong, number) in enumerate(
        zip(*bench.history.values(), strict=True), start=1) if is_dropped}
    assert not left.keys() & dropped.keys()
    cycles, came = zip(*sorted({**left, **dropped}.items()), strict=True)
    return [*came], {"in": bench.cycles["i"], "out": cycles}


@pytest.mark.parametrize(("generation_bits", "word_bits", "count"), [(1, 2, 64), (2, 16, 64), (3, 4, 128)])
def test_every_generation_begins_empty(generation_bits, word_bits, count):
    """Tags run out several times; a number passes once in each generation."""
    generations = [numbers(seed, 40) for seed in range(12)]
    came, _ = run(make(generation_bits, word_bits, count), generations)
    golden, expected = GoldenFilter(LIMIT, tag_bits=2), []
    for given in generations:
        golden.clear()
        expected += [(int(number), "wrong" if number >= LIMIT else
                      "passes" if len(golden.first(np.array([number]))) else "dropped") for number in given]
    assert came == expected


@pytest.mark.parametrize(("generation_bits", "word_bits", "count"), [(1, 2, 64), (2, 2, 64), (3, 2, 128)])
def test_a_word_that_no_generation_has_touched_for_long_is_empty(generation_bits, word_bits, count):
    """However many generations lie between, and whether or not the tags have run out meanwhile: the first generation
    takes a number of each word, each later one that of a word of its own.
    """
    most = min(LIMIT // word_bits, 2 * (1 << generation_bits) + 3)
    alone = [np.array([word * word_bits]) for word in range(1, most)]
    came, _ = run(make(generation_bits, word_bits, count), [np.concatenate(alone), *alone])
    assert came == [(int(number), "passes") for given in (np.concatenate(alone), *alone) for number in given]


def test_one_number_per_cycle_whether_it_passes_or_not():
    _, cycles = run(make(), [numbers(4, 100)])
    assert np.diff(cycles["in"]).tolist() == np.diff(cycles["out"]).tolist() == [1] * 99


def test_goldens_stimulus():
    of, config = block("memsys.filter")[1], PRESETS["tiny"]
    given = of.draw(np.random.default_rng(5), 300, config)
    generations = np.split(given["number"], np.flatnonzero(given["clears"]))
    came, _ = run(Filter(bits=6, count=32, generation_bits=2, word_bits=8), generations, limit=32)
    passes = of.expect(given, config)["passes"]
    assert [(number, how == "passes") for number, how in came] == list(
        zip(given["number"].tolist(), passes.astype(bool).tolist(), strict=True))


@pytest.mark.parametrize(("changes", "message"), [
    ({"word_bits": 3}, "Word bits must be a power of two, at least 2, not 3"),
    ({"count": 16}, "Count must be a power of two, at least 32, not 16"),
    ({"bits": 5}, "Bits must be at least 6, not 5")])
def test_init_wrong(changes, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        Filter(**{"bits": 8, "count": 64, "generation_bits": 2, **changes})
