"""The windows of subshells are golden's, with few multipliers."""

from functools import partial
from itertools import pairwise

import pytest

from hw.ctu.subshell_windows import SubshellWindows
from tb.ctu.subshell_patches import CASES, SubshellPatches
from tb.lib.bench import Bench, Case, Vectors
from tb.lib.configurations import CONFIGURATIONS, config_of
from tb.lib.coverage import Coverage
from tb.lib.responder import responder
from tb.lib.runner import SLOW_IN_ICARUS

RUNS = [("hemisphere", 3), ("screen", 4), ("hemisphere", 5)]
# Patches at the borders of rays, of each of these.
AT_BORDERS = 240
# Cycles from a subshell's patch to the next one's.
RATE = 64
# By registers of a multiplier the least interval.
INTERVALS = {1: 18, 2: 15, 3: 20}


def subshells(config, kind, **options):
    given = SubshellPatches(kind, config, **options)
    return Vectors(
        inputs={"i": given.items}, first={"i_table": given.tables}, ports=given.ports, about=given,
        expected={"o": [{"last": 1, "shell": None, "window": None} if window["last"] else window
                        for window in given.windows], "o_patch": given.patches.tolist()})


def at_borders(kind, seed, config):
    """In the largest frusta, of patches for whose windows the low bits matter."""
    return subshells(config, kind, seed=seed, count=AT_BORDERS, size=(1 << config.icu.side_bits,) * 2, at_borders=True)


class TestSubshellWindows(Bench):
    component = SubshellWindows
    cases = {"rate": Case(lambda config: subshells(config, "hemisphere", seed=3, count=40), [{}]),
             **{f"borders of a {kind}, {seed}": Case(partial(at_borders, kind, seed), [], timed=False)
                for kind, seed in RUNS}}
    simulators = SLOW_IN_ICARUS
    cycles = 200_000

    def drawn(self, config, seed):
        return subshells(config, ("hemisphere", "screen")[seed % 2], count=12, seed=seed)

    def latency(self, component, config):
        return component.latency

    @responder("o_patch", "i_vertex")
    def memory(self, patch):
        """The patches' vertices."""
        return self.now.about.beats(patch)

    def check_times(self, given, cycles, latency):
        entered, kept = cycles["i_vertex"][::4], given.about.kept[given.about.patches]
        assert {b - a for a, b in pairwise(entered)} == {RATE}, "patches must be taken without a gap"
        assert cycles["o"][0] - entered[kept.argmax()] == latency


@pytest.mark.sim
class TestOtherIntervals(TestSubshellWindows):
    """Few subshells of a screen, with the least interval."""

    variants = ({"icu.product_registers": 1},)
    cases = {"few": Case(lambda config: subshells(config, "screen", seed=4, count=9), timed=False)}
    test_in_the_simulator = None

    def make(self, config):
        return SubshellWindows(config=config, interval=INTERVALS[config.icu.product_registers])


@pytest.mark.nightly
class TestLeastIntervals(TestOtherIntervals):
    variants = ({}, {**CONFIGURATIONS["narrow"], "icu.product_registers": 3})


def test_the_subshells_hold_every_case():
    coverage = Coverage(CASES)
    for kind, seed in RUNS:
        SubshellPatches(kind, config_of({}), seed=seed, count=200).hit(coverage)
    coverage.check()


@pytest.mark.parametrize(("value", "error"), [(14, ValueError), (18.0, TypeError)])
def test_init_wrong_interval(value, error):
    with pytest.raises(error, match=f"^Interval must be at least 15, not {value!r}$"):
        SubshellWindows(config=config_of({}), interval=value)
