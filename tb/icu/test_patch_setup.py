from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring

from golden.engine.config import PRESETS
from golden.engine.ctu.sector import Sector
from golden.engine.icu.section_clip import section_clip
from golden.engine.icu.settle_code import settle_threshold
from golden.engine.icu.window import Window
from golden.engine.stimulus import block
from golden.engine.stimulus.frusta import SOURCE, frustum_arrays, random_hemisphere, random_screen
from golden.engine.stimulus.patches import scene_patches
from hw.formats import SURFACE_BITS
from hw.icu.patch_setup import PatchSetup
from radiosity.flow.board.soc import SOC
from radiosity.flow.package.example.frustum_load import frustum_payload, table_writes
from tb.icu.vectors import WINDOW, factor_of, rows, section_window_of, winding_of
from tb.lib.configurations import CONFIGURATIONS, config_of
from tb.lib.coverage import Coverage
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.stall_patterns import STALLS

COUNT = 84
PARTS = ("planes", "winding", "factor", "exponents")
VARIANTS = {
    "default": config_of({}), "1 register": config_of({"icu.product_registers": 1}),
    "3 registers, narrow": config_of({**CONFIGURATIONS["narrow"], "icu.product_registers": 3}),
    # Patches follow each other until they have all slots; in the last one the window comes after the plane factor.
    "few slots": config_of({"icu.slots": 16}), "board": PRESETS["board"], "SoC": SOC, "late windows": config_of({
        "icu.slots": 16, "icu.cordic_stages": 20, "icu.product_registers": 1, "numbers.mantissa_bits": 18})}
# Configuration, frustum, and whether all of it is the section.
RUNS = [("default", "hemisphere", True), ("default", "screen", True), ("1 register", "hemisphere", False),
        ("3 registers, narrow", "screen", False)]
# Configurations with the fewest slots.
FEW_SLOTS = [name for name, config in VARIANTS.items() if config.icu.slots == 16]
# Vertices that wait for a slot.
QUEUED = 8
FRUSTA = {"hemisphere": random_hemisphere, "screen": random_screen}
# By frustum: a section that windows go round, and the middle of a screen.
SECTIONS = {"hemisphere": (5, 60, 0, 13), "screen": (7, 50, 4, 45)}


class Setup(wiring.Component):
    """Patch setup of which a slot is free again as soon as its window has been taken."""

    def __init__(self, config):
        self._setup = PatchSetup(config=config)
        self.latency = self._setup.latency
        members = dict(self._setup.signature.members.items())
        del members["free"]
        super().__init__(members)

    def elaborate(self, platform):
        m = Module()
        m.submodules.setup = setup = self._setup
        for name in self.signature.members:
            if name != "frustum":
                wiring.connect(m, wiring.flipped(getattr(self, name)), getattr(setup, name))
        m.d.comb += [setup.frustum.eq(self.frustum), setup.free.eq(setup.o.valid & setup.o.ready)]
        return m


class Patches:
    """Hard and random patches around the origin of a frustum, and what golden makes of them."""

    def __init__(self, kind, config, *, whole, seed=5):
        random = np.random.default_rng(seed)
        self.config, self.record = config, FRUSTA[kind](random, config)
        self.section = Sector.whole(self.record) if whole else Sector(*SECTIONS[kind])
        surface = random.integers(0, 4 * SOURCE, COUNT)
        surface[::5] = SOURCE + (1 << SURFACE_BITS // 2)
        self.given = {**frustum_arrays(self.record), "surface": surface,
                      "vertices": scene_patches(random, COUNT, self.record.origin, config.numbers)}
        # A line, a point, and what is so small that it is seen as a point.
        vertices, low = self.given["vertices"], 1 << config.numbers.scene_bits - 8
        vertices[-3, 1::2], vertices[-3, 2] = vertices[-3, 0] + low, vertices[-3, 0]
        vertices[-2] = vertices[-2, 0]
        vertices[-1] = self.record.origin + 20 * low + [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
        self.made = block("icu.patch_setup")[1].expect(self.given, config)
        window = Window(*(self.made[name] for name in WINDOW))
        self.window = section_clip(window, self.section, self.record)

    def schedule(self, vertex_stalls="none", stalls=()):
        """Tables, then vertices."""
        pattern = STALLS[vertex_stalls](1)
        vertices = [{"patch": k, "surface": int(self.given["surface"][k]), "vertex": vertex}
                    for k in range(COUNT) for vertex in rows(self.given["vertices"][k])]
        idle = [2] + [next(pattern) * 3 for _ in vertices[1:]]
        return Schedule(stalls={"o": list(stalls)}, first={"i_table": table_writes(self.record, self.config)},
                        items={"i": list(zip(idle, vertices, strict=True))})

    def expected(self):
        """By output."""
        slots, made = self.config.icu.slots, self.made
        parts = {"planes": lambda k: rows(made["planes"][k]), "winding": lambda k: winding_of(made, k),
                 "factor": lambda k: factor_of(made, k), "exponents": lambda k: rows(made["exponents"][k])}
        threshold = settle_threshold(made["bound"], self.config)
        if not self.config.icu.uv_bits:
            del parts["exponents"]
        return {**{f"o_{name}": [{"slot": k % slots, "part": part(k)} for k in range(COUNT)]
                   for name, part in parts.items()},
                "o_patch": [{"slot": k % slots, "part": k} for k in range(COUNT) for _ in range(4)],
                "o": [{"slot": k % slots, "window": section_window_of(self.window, k),
                       # No unit uses the threshold of what cannot be hit.
                       "threshold": int(threshold[k]) if made["live"][k] else None} for k in range(COUNT)]}

    def check(self, came):
        """All outputs are golden's."""
        for name, expected in self.expected().items():
            assert len(came[name]) == len(expected), f"{name}: {len(came[name])} items came, not {len(expected)}"
            for k, (item, required) in enumerate(zip(came[name], expected, strict=True)):
                if required.get("threshold", 0) is None:
                    item = {**item, "threshold": None}
                assert item == required, f"{name}: item {k} differs"

    def cases(self):
        """What these patches are, case by case."""
        made, vertices = self.made, self.given["vertices"]
        window, live, record = self.window, made["live"] > 0, self.record
        triangle = (vertices[:, 2] == vertices[:, 3]).all(axis=1)
        oriented = made["orientation"].any(axis=1)
        height = (vertices - record.origin) @ record.matrix[2]
        threshold = settle_threshold(made["bound"], self.config)
        return {
            "quad": ~triangle & live, "triangle": triangle & live, "in two triangles": (made["split"] > 0) & live,
            "degenerate": ~oriented, "dropped": (made["dropped"] > 0) & oriented,
            "the source's own": (self.given["surface"] == record.source) & oriented & (made["dropped"] == 0),
            "a surface like the source in its low bits": (
                self.given["surface"] == record.source + (1 << SURFACE_BITS // 2)) & live,
            "through the plane of the eye": live & (height.min(axis=1) < 0) & (height.max(axis=1) > 0),
            "behind": live & (height.max(axis=1) < 0),
            "without rays": window.rays == 0, "one ray": window.rays == 1,
            "one piece": (window.rays > 0) & (window.wrapped_count == 0), "two pieces": window.wrapped_count > 0,
            "all columns": made["column_count"] == record.columns,
            "pole inside": live & (made["row_first"] == 0) & (made["column_count"] == record.columns),
            "cut by the section": (made["column_count"] * made["row_count"] > window.rays) & (window.rays > 0),
            "nearest threshold": live & (threshold == self.config.icu.settle.high + 1),
            "between": live & (threshold > 1) & (threshold <= self.config.icu.settle.high)}


@cache
def bench_of(name):
    config = VARIANTS[name]
    component = Setup(config)
    bench = ScheduleBench(component, idle_limit=component.latency + 20)
    return config, component, bench


def run(name, patches, **regime):
    """All outputs are golden's; the component, and the cycles of all transfers."""
    config, component, bench = bench_of(name)
    frustum = frustum_payload(patches.record, patches.section, config)
    patches.check(bench.run(patches.schedule(**regime), frustum=frustum))
    return component, bench.cycles


@pytest.mark.sim
@pytest.mark.parametrize(("name", "kind", "whole"), [
    RUNS[1], *(pytest.param(*other, marks=pytest.mark.nightly) for other in (RUNS[0], *RUNS[2:]))])
def test_a_quad_every_four_cycles(name, kind, whole):
    component, cycles = run(name, Patches(kind, VARIANTS[name], whole=whole))
    assert {b - a for a, b in pairwise(cycles["i"])} == {1}, "vertices must be taken without a gap"
    assert {b - a for a, b in pairwise(cycles["o"])} == {4}, "windows must come without a gap"
    assert cycles["o"][0] - cycles["i"][3] == component.latency


@pytest.mark.sim
@pytest.mark.parametrize(("name", "kind"), [
    pytest.param(name, kind, marks=[] if name == "late windows" and kind == "screen" else pytest.mark.nightly)
    for name in FEW_SLOTS for kind in FRUSTA])
def test_a_queue_holds_all_patches_that_arrive_while_one_waits(name, kind):
    """Of each component the queues' lengths follow from its own latencies."""
    run(name, Patches(kind, VARIANTS[name], whole=True))


def test_the_vectors_hold_every_case():
    coverage = None
    for name, kind, whole in RUNS:
        cases = Patches(kind, VARIANTS[name], whole=whole).cases()
        coverage = coverage or Coverage(cases)
        coverage.hit_all(cases)
    coverage.check()


@pytest.mark.sim
def test_vertices_wait_while_all_slots_are_taken():
    patches = Patches("hemisphere", config_of({}), whole=True)
    _, cycles = run("default", patches, stalls=[700, *(k % 7 for k in range(COUNT))])
    before = sum(cycle < cycles["o"][0] for cycle in cycles["i"])
    assert before == 4 * patches.config.icu.slots + QUEUED, "as many as there are slots, and those that wait for one"


@pytest.mark.nightly
def test_stalls_of_both_ends():
    patches = Patches("screen", config_of({}), whole=True)
    run("default", patches, vertex_stalls="random", stalls=[k * k % 11 for k in range(COUNT)])
