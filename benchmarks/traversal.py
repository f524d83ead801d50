"""Cycles of cell traversal by the golden model's counts, without the RTL.

``radiosity bench traversal`` writes out/bench/traversal.md: grid rays sent with few slots, the busiest cluster's cell
traversal beside the busiest cluster's intersection, and stages that overlap beside a barrier after each.
"""

from collections import Counter
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from benchmarks.ceiling import CELL, HEMISPHERE, POINTS, RATIO, SCENES, Ceiling
from benchmarks.grades import signed
from benchmarks.report import benchmark, provenance, table, write_report
from golden.engine.cast.shelling import ShellingCounts
from golden.engine.config import Config
from golden.engine.ctu.sector import Sector, sector_rays, subshell_rays
from golden.engine.ctu.settle_pyramid import SettlePyramid
from golden.engine.ctu.survival import survivors_by_code
from golden.engine.icu.ray_memory import RayMemory
from radiosity.cli.console import console

CONFIG = Config()
CLUSTERS = (1, 2, 4, 8, 16)
# Subshells at once, and shells of each that are ahead of what is known; the first is the barrier.
WAYS = ((1, 0), (1, 1), (1, CONFIG.ctu.run_ahead), (2, 0), (4, 0), (4, CONFIG.ctu.run_ahead), (8, CONFIG.ctu.run_ahead))
SLOTS = (1024, 4096, 16384)
# Cycles from a cell to the first vertices of its patches, and from there to the settle map (docs/intersection-unit.md).
MEMORY, INTERSECTION = 60, 202


@dataclass(frozen=True)
class Rates:
    """Of a ray generator: cycles per grid ray sent out, and grid rays looked at in a cycle."""

    issue: int
    looks: int

    def cycles(self, work, pipelines: int) -> int:
        """Of a stage, or of all of them: ``scanned``, ``grid_rays`` and ``passes`` of ``work``."""
        return max(-(-work.scanned // self.looks), self.issue * work.grid_rays, -(-work.passes // pipelines))


SLOW, FAST = Rates(issue=2, looks=1), Rates(issue=1, looks=4)


def patch_cycles(work: ShellingCounts) -> int:
    """What intersection takes."""
    return max(work.walk_cycles, 4 * work.patches)


def balance(name: str, ceiling: Ceiling) -> list[list]:
    """The busiest cell traversal beside the busiest intersection, with single and with four look-ups, by clusters."""
    cells = []
    for clusters in CLUSTERS:
        plan, pipelines = ceiling.plan(clusters), CONFIG.ctu.traversal_pipelines(clusters)
        casts = [ceiling.shelling.cast(ceiling.record(point), plan.partition.sections, plan.subshells)[1]
                 for point in POINTS]

        def worst(cycles, casts=casts):
            return np.array([max(map(cycles, counts)) for counts in casts])

        icu = worst(patch_cycles)
        cells.append(", ".join(_ratio(worst(lambda one, rates=rates, lanes=pipelines: rates.cycles(one, lanes)), icu)
                               for rates in (SLOW, FAST)))
    return [[name, *cells]]


def _ratio(cycles, against):
    longer = np.count_nonzero(cycles > against)
    bold = "**" if longer else ""
    return f"{bold}{(cycles / against).mean():.2f} ({longer}){bold}"


class Timed:
    """One cluster's stages in time.

    Parameters
    ----------
    rates, pipelines
        Of cell traversal.
    at_once
        Subshells in flight. Of those whose next shell may begin, the one that could do so first continues.
    run_ahead
        Shells of a subshell that begin before the hits of the one before them are known; 0 is a barrier after each.
        Survival sees all hits that are known when a shell begins.
    """

    def __init__(self, ceiling: Ceiling, record, *, rates: Rates, pipelines: int, at_once: int, run_ahead: int):
        self._ceiling, self._record, self._rates, self._lanes = ceiling, record, rates, pipelines
        self._at_once, self._run_ahead = at_once, run_ahead
        self.memory = RayMemory(len(record), CONFIG)
        self._tests = ceiling.shelling.tests(record, self.memory)
        self.overlap = 0

    def cycles(self, sector: Sector, subshells) -> int:
        """From the start to the last hit of a cluster."""
        cluster = self._ceiling.shelling.cluster(self._record, sector)
        schedule = cluster.schedule(subshells, self._tests.window)
        groups = [list(group) for _, group in groupby(schedule, lambda one: one[0])]
        # Of each subshell, when the hits of its shells are known (the first one has shell 1), and when it may begin.
        over, gate = [[] for _ in groups], [0] * len(groups)
        known, spans = [(0, self.memory.inverse)], []
        opened = tested = 0

        def behind(group):
            return over[group][:len(over[group]) - self._run_ahead][-1:]

        def ready(group):
            return max([opened, gate[group], *behind(group), *(over[0][:1] if group else ())])

        waiting = list(range(len(groups)))
        while waiting:
            group = min(waiting[:self._at_once if over[0] else 1], key=ready)
            begin, (number, shell, window) = ready(group), groups[group].pop(0)
            while len(known) > 1 and known[1][0] <= begin:
                known.pop(0)
            stage = cluster.explore(number, shell, window, known[0][1])
            if stage is not None:
                counts = ShellingCounts()
                self._tests.run(stage, sector, counts)
                opened = begin + self._rates.cycles(stage, self._lanes)
                tested = max(max(tested, begin + MEMORY) + patch_cycles(counts), opened + MEMORY)
                # A stage that finds nothing has nothing to wait for in the intersection unit.
                over[group].append(tested + (INTERSECTION if len(stage.found) else 0))
                known.append((max(known[-1][0], over[group][-1]), self.memory.inverse))
                spans.append((begin, over[group][-1], group))
            if not groups[group]:
                waiting.remove(group)
                # The next one takes its turn.
                for later in waiting[self._at_once - 1:self._at_once]:
                    gate[later] = max([gate[group], *behind(group)])
        self.overlap += _overlap(spans)
        return max(end for _, end, _ in spans)


def _overlap(spans) -> int:
    """Cycles in which spans of two groups or more are in flight."""
    events = sorted((time, change, group) for begin, end, group in spans for time, change in ((begin, 1), (end, -1)))
    in_flight, total, last = Counter(), 0, 0
    for time, change, group in events:
        total += (time - last) * (sum(count > 0 for count in in_flight.values()) > 1)
        in_flight[group] += change
        last = time
    return total


def overlap(name: str, ceiling: Ceiling) -> list[list]:
    """Shells that overlap beside a barrier after each."""
    rows = []
    for clusters in 1, 8:
        plan, pipelines = ceiling.plan(clusters), CONFIG.ctu.traversal_pipelines(clusters)
        for listed, subshells, policies in (
                ("last only", [None] * clusters, WAYS[:3]), ("lists", plan.subshells, WAYS)):
            record, results = ceiling.record(POINTS[0]), []
            for at_once, run_ahead in policies:
                timed = Timed(ceiling, record, rates=FAST, pipelines=pipelines, at_once=at_once, run_ahead=run_ahead)
                took = [timed.cycles(sector, one) for sector, one in zip(plan.partition.sections, subshells,
                                                                        strict=True)]
                results.append((max(took), timed.overlap // clusters, timed.memory.inverse))
            if any((inverse != results[0][2]).any() for _, _, inverse in results):
                raise SystemExit(f"error: {name}: the order changes the hits")
            cycles = [cycles for cycles, _, _ in results] + ["-"] * (len(WAYS) - len(policies))
            best = min(results, key=lambda result: result[0])
            rows.append([name, clusters, listed, *cycles, f"{results[0][0] / best[0]:.2f}", best[1]])
    return rows


def slots(name: str, ceiling: Ceiling) -> list[list]:
    """Grid rays sent with few slots in the ray memory, of those sent with one for each of them."""
    record, plan = ceiling.record(POINTS[0]), ceiling.plan(1)
    sector, memory = plan.partition.sections[0], RayMemory(len(record), CONFIG)
    tests, cluster = ceiling.shelling.tests(record, memory), ceiling.shelling.cluster(record, sector)
    unit = cluster.traversal
    grids = [unit.rays(shell) for shell in range(2, unit.last_shell + 1)]
    sizes = [grid.rows * grid.columns for grid in grids]
    first = np.cumsum([0, *sizes])
    seen = {count: np.full(count, -1) for count in (*SLOTS, int(first[-1]))}
    sent = dict.fromkeys(seen, 0)
    for position in cluster.schedule(plan.subshells[0], tests.window):
        inverse = memory.inverse
        stage = cluster.explore(*position, inverse)
        if stage is None:
            continue
        if stage.shell > 1:
            rays = grids[stage.shell - 2]
            pyramid = SettlePyramid.of(inverse.reshape(record.rows, record.columns), sector, CONFIG)
            inside = sector_rays(rays, sector, record)
            if stage.window is not None:
                inside &= subshell_rays(rays, stage.window, record)
            going = inside & survivors_by_code(rays, pyramid, unit.threshold(stage.shell, CONFIG), sector, record)
            number = first[stage.shell - 2] + np.flatnonzero(going)
            for count, slot in seen.items():
                other = number[slot[number % count] != number]
                sent[count] += len(other)
                slot[other % count] = other
        tests.run(stage, sector, ShellingCounts())
    *few, every = sent.values()
    return [[name, first[-1], every, *(signed(more / every - 1, 0) for more in few)]]


@benchmark("traversal", SCENES)
def main(scenes: tuple[str, ...]) -> None:
    """Compare cell traversal with intersection, cycle by cycle; SCENES default to the thesis' five."""
    ceilings, tables = {name: Ceiling(name, CONFIG, by_code=True) for name in scenes}, []
    for measure in slots, balance, overlap:
        tables.append([row for name, ceiling in ceilings.items() for row in measure(name, ceiling)])
        console().note(f"{measure.__name__}: measured")
    again, balances, overlaps = tables
    write_report(
        "Cell traversal", provenance("numpy") + ".",
        f"Hemispheres of {HEMISPHERE.azimuths} x {HEMISPHERE.polars} rays, cell {CELL}, from points 4, 7, 10 and 13 of "
        f"the ceiling, sections and subshells from point 1 (ratio {RATIO}). Cycles are golden's counts at the stated "
        "rates.",
        "## Slots of the ray memory",
        "Point 4, one cluster, subshells, barrier order: grid rays that there are, those sent with a slot for each, "
        "and how many more with so many slots (`ctu.ray_slots`).",
        table(["scene", "grid rays", "sent", *SLOTS], again),
        "## The busiest cell traversal beside the busiest intersection",
        "CTU : ICU, means over the points, and in how many of the frusta the CTU takes longer (bold): max(2 x grid "
        "rays sent, grid rays looked at, turns / pipelines), and with one sent and four looked at in a cycle. Turns "
        "are cell steps, and one for a ray that begins outside the grid for good. ICU: max(cycles of the window "
        "walks, 4 x patches).",
        table(["scene", *CLUSTERS], balances),
        "## Overlap",
        f"Cycles of the busiest cluster, four look-ups, point 4; {MEMORY} cycles from a cell to its patches and "
        f"{INTERSECTION} from there to the settle map. The hits are the same.",
        ["* Ahead n, a run-ahead depth of n: a shell of a subshell begins when the hits of all but the n shells before "
         "it are known, and survival uses the hits known then. The first column has a barrier after each shell.",
         "* Two in flight: cycles in which two subshells or more are in flight, per cluster, in the fastest column."],
        table(["scene", "clusters", "subshells", *(f"{at_once} at once, ahead {ahead}" for at_once, ahead in WAYS),
               "barrier : fastest", "two in flight"], overlaps))
