"""The windows of subshells are golden's, with few multipliers."""

from functools import partial

import pytest

from hw.ctu.subshell_windows import SUBSHELLS, SubshellWindows
from hw.icu.ipbb import Ipbb
from hw.icu.sbb import Sbb
from tb.ctu.subshell_patches import CASES, SubshellPatches
from tb.lib.bench import Bench, Case, Vectors
from tb.lib.configurations import CONFIGURATIONS, config_of
from tb.lib.coverage import Coverage
from tb.lib.responder import responder
from tb.lib.runner import SLOW_IN_ICARUS
from tb.lib.timing import documented_latency

RUNS = [("hemisphere", 3), ("screen", 4), ("hemisphere", 5)]
# Patches at the borders of rays, of each of these.
AT_BORDERS = 240
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

    def interval_of(self, config):
        """Cycles from a vertex to the next one."""
        return 16

    def predict(self, given, trace, component, config):
        """As many subshells wait as there are entries; windows leave in their order, those without rays silently."""
        interval, ports = self.interval_of(config), given.ports["frustum"]
        behind = component.latency - 3 * interval
        if ports["is_screen"]:
            behind -= documented_latency(Sbb, config, interval=interval) - documented_latency(Ipbb, config)
        found = {name: [] for name in ("i", "o_patch", "i_vertex", "o")}
        answered, left, vertex = iter(trace.offered["i_vertex"]), [0] * SUBSHELLS, 0
        for item, offered in zip(given.inputs["i"], trace.offered["i"], strict=True):
            accepted, is_last = max(offered, left[-SUBSHELLS] + 1), "last" in item
            if not is_last:
                accepted = trace.ready("o_patch", accepted)
                found["o_patch"].append(accepted)
                for _ in range(4):
                    vertex = max(next(answered), vertex + interval)
                    found["i_vertex"].append(vertex)
            found["i"].append(accepted)
            left.append(max(accepted + 1, left[-1] + 1, 0 if is_last else vertex + behind))
            if is_last or given.about.kept[item["patch"]]:
                left[-1] = trace.ready("o", left[-1])
                found["o"].append(left[-1])
        return found


@pytest.mark.sim
class TestOtherIntervals(TestSubshellWindows):
    """Few subshells of a screen, with the least interval."""

    variants = ({"icu.product_registers": 1},)
    cases = {"few": Case(lambda config: subshells(config, "screen", seed=4, count=9), timed=False)}
    test_in_the_simulator = None

    def interval_of(self, config):
        return INTERVALS[config.icu.product_registers]

    def make(self, config):
        return SubshellWindows(config=config, interval=self.interval_of(config))


@pytest.mark.nightly
class TestLeastIntervals(TestOtherIntervals):
    variants = ({}, {**CONFIGURATIONS["narrow"], "icu.product_registers": 3})


def test_the_subshells_hold_every_case():
    coverage = Coverage(CASES)
    for kind, seed in RUNS:
        SubshellPatches(kind, config_of({}), seed=seed, count=200).hit(coverage)
    coverage.check()


def test_init_wrong_interval():
    with pytest.raises(ValueError, match=r"^Interval must be at least 15, not 14$"):
        SubshellWindows(config=config_of({}), interval=14)
