"""The ray generator requests golden's grid rays, subshell by subshell and shell by shell, in their order."""

from functools import cache
from itertools import pairwise

import pytest

from golden.engine.stimulus.ctu.records import traversal_record
from hw.ctu.ct_ray_generator import CtRayGenerator
from hw.ctu.ctu_formats import GRID_GROUP
from tb.ctu.window_stages import CASES, SECTORS, RecordStages, WindowStages
from tb.lib.bench import Bench, Case, Vectors
from tb.lib.configurations import config_of
from tb.lib.coverage import Coverage
from tb.lib.responder import Responder, responder
from tb.lib.runner import SLOW_IN_ICARUS
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency

# Between the beginnings of short rows.
ROW_CYCLES = 5
# Frustum, sector and seed.
RUNS = [(kind, sector, 3 + sector) for kind, sectors in SECTORS.items() for sector in range(len(sectors))]


# No stage waits for those before it, but where a test says otherwise.
CHANGES = {"ctu.run_ahead": 15}


def requests(stages):
    """Golden's requests; see `check`."""
    return Vectors(inputs={"i": stages.items}, first={"i_table": stages.tables}, ports=stages.ports,
                   expected={"o": [None] * len(stages.requests)}, about=stages)


def check(came, stages):
    """``came``: the payloads in their order; of groups each ray is looked at."""
    assert all(item["count"] <= GRID_GROUP for item in came)
    came = [{**item, "ray": item["ray"] + k, "column": item["column"] + k, "count": min(1, item["count"])}
            for item in came for k in range(max(1, item["count"]))]
    required = stages.requests
    for number, (got, item) in enumerate(zip(came, required, strict=False)):
        different = {name: (got[name], value) for name, value in item.items() if got[name] != value}
        flags = {name: got[name] for name in ("count", "last", "final") if got[name] != item.get(name, 0)}
        assert not different, f"request {number} of {len(required)}: (got, required) {different}"
        assert not flags, f"request {number} of {len(required)}: {flags} must not be"
    assert len(came) == len(required)


def check_rate(came, cycles, stages):
    """Groups follow each other in rows, and rows each other, as the docstring states."""
    by_stage = {}
    for item, cycle in zip(came, cycles["o"], strict=True):
        if item["count"]:
            by_stage.setdefault(item["stage"], {}).setdefault(item["row"], []).append((cycle, item["count"]))
    assert len(by_stage) == stages.last_shell - 1
    for rows in by_stage.values():
        for row in rows.values():
            assert row[-1][0] - row[0][0] + 1 == len(row), "groups of a row must follow each other without a gap"
            assert all(count == GRID_GROUP for _, count in row[:-1]), "groups but the last one of a row must be full"
        for before, row in pairwise(rows.values()):
            assert row[0][0] - before[0][0] <= max(len(before), ROW_CYCLES), (
                "a row must begin when the last one has left")


class TestCtRayGenerator(Bench):
    component, changes = CtRayGenerator, CHANGES
    cases = {"rate": Case(lambda config: requests(WindowStages("hemisphere", config, seed=4, last_shell=8).only(
        slice(0, 0))), [{}])}
    simulators = SLOW_IN_ICARUS
    # Until the last stage is over.
    idle_limit = 100
    cycles = 600_000

    def drawn(self, config, seed):
        kind, sector, _ = RUNS[seed % len(RUNS)]
        return requests(WindowStages(kind, config, seed=seed, sector=sector, last_shell=3 + seed % 3))

    def latency(self, component, config):
        # It depends on the shell: see `check_cycles`.
        return 0

    @responder("o", "i_over", after=(3, 43))
    def end(self, item):
        """A stage is over some cycles after its last item."""
        return [0] * item["last"]

    def is_over(self, given, came):
        return bool(came["o"]) and self.values("o", {"o": came["o"][-1:]})[0]["final"]

    def check(self, given, came):
        self.came = self.values("o", came)
        check(self.came, given.about)

    def check_cycles(self, given, trace, component, config):
        """Of the last subshell alone: the first ray comes after the latency, the groups of a piece follow each other.

        Other cycles have no rule of latency, interval and capacity: a piece takes a search or none, by the ends of arcs
        for which earlier searches are kept, and the groups do not say where one piece ends and the next one begins.
        """
        if len(given.inputs["i"]) > 1:
            return
        rays, cycles = given.about.rays[2], trace.cycles["o"]
        latency = documented_latency(CtRayGenerator, config, rows=rays.rows, columns=rays.columns)
        assert cycles[0] == trace.ready("o", trace.cycles["i"][0] + latency)
        follow = [number for number, (before, item) in enumerate(pairwise(self.came), start=1) if item["count"] and (
            GRID_GROUP, item["stage"], item["row"], item["ray"] - GRID_GROUP) == tuple(
                before[name] for name in ("count", "stage", "row", "ray"))]
        assert follow
        assert [cycles[number] for number in follow] == [trace.ready("o", cycles[number - 1] + 1) for number in follow]


@cache
def bench_of(**changes):
    return ScheduleBench(CtRayGenerator(config=config_of({**CHANGES, **changes})), idle_limit=300, watchdog=100_000)


def run(stages, changes, *, over=20, stalls=()):
    """The requests, the same in any case, and the cycles of transfers; a stage is over after some cycles."""
    bench = bench_of(**changes)
    came = bench.run(
        Schedule(items={"i": [(0, item) for item in stages.items]}, first={"i_table": stages.tables},
                 stalls={"o": stalls}),
        Responder("o", "i_over", lambda item: [0] * item["last"], over), **stages.ports)["o"]
    check(came, stages)
    return came, bench.cycles


@pytest.mark.parametrize(("scene", "cell", "clusters"), [
    ("cornell", 0.5, 2), pytest.param("lobby", 0.125, 2, marks=pytest.mark.nightly),
    pytest.param("room1627", 0.0625, 4, marks=pytest.mark.nightly)])
def test_rays_of_scenes(scene, cell, clusters):
    record = traversal_record(scene, cell=cell, config=config_of({"ctu.subshell_bits": 10}), clusters=clusters)
    for number in range(clusters):
        stages = RecordStages(record, number, config_of(CHANGES))
        requested = stages.requested()
        # Golden leaves out stages in which nothing may change.
        assert {stage: requested.get(stage, 0) for stage in stages.scanned} == stages.scanned
        run(stages, {}, stalls=[k * k % 5 for k in range(200)])


def in_flight(came, cycles):
    """Of each stage when it begins: its shell, and how many begun ones are not over."""
    begun, ended = [], cycles["i_over"]
    for item, cycle in zip(came, cycles["o"], strict=True):
        if not item["final"] and item["stage"] not in [stage for stage, _ in begun[-1:]]:
            begun.append((item["stage"], cycle))
            yield item["shell"], len(begun) - sum(end <= cycle for end in ended)


@pytest.mark.parametrize("run_ahead", [pytest.param(0, marks=pytest.mark.sim), 2])
def test_stages_wait_for_those_before(run_ahead):
    stages = WindowStages("hemisphere", config_of({}), seed=9, sector=1, last_shell=4)
    came, cycles = run(stages, {"ctu.run_ahead": run_ahead}, over=60)
    assert max(stages for _, stages in in_flight(came, cycles)) == run_ahead + 1


def test_a_barrier_between_subshells():
    stages = WindowStages("hemisphere", config_of({}), seed=9, sector=1, last_shell=4)
    begun = list(in_flight(*run(stages, {"ctu.subshell_barrier": 1}, over=60)))
    assert all(stages == 1 for shell, stages in begun if shell == 2), "a subshell must wait for the one before"
    assert any(stages > 1 for _, stages in begun), "shells of a subshell must overlap"


@pytest.mark.sim
def test_a_group_per_cycle():
    stages = WindowStages("hemisphere", config_of({}), seed=4, last_shell=6).only(slice(0, 0))
    check_rate(*run(stages, {}), stages)


def test_the_windows_hold_every_case():
    coverage = Coverage(CASES)
    for kind, sector, seed in RUNS:
        WindowStages(kind, config_of({}), seed=seed, sector=sector).hit(coverage)
    coverage.check()
