"""Cycles of cell traversal by the golden model's counts, without the RTL.

``radiosity bench traversal`` writes out/bench/traversal.md: what survival by settle codes costs, the busiest
cluster's cell traversal beside the busiest cluster's intersection, and stages that overlap beside a barrier after each.
"""

from collections import Counter
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import click
import numpy as np

from benchmarks.ceiling import CELL, HEMISPHERE, POINTS, RATIO, SCENES, Ceiling
from benchmarks.report import output_option, provenance, write_report
from golden.engine.cast.shelling import Shelling, ShellingCounts
from golden.engine.config import Config
from golden.engine.ctu.cell_traversal import Traversal
from golden.engine.ctu.grid_rays import INDEX_FRACTION
from golden.engine.ctu.sector import Sector, sector_rays, subshell_rays
from golden.engine.ctu.settle_pyramid import SettlePyramid
from golden.engine.ctu.survival import survivors_by_code
from golden.engine.ctu.unit import CellTraversalUnit, global_directions
from golden.engine.icu.ray_memory import RayMemory
from golden.engine.icu.section_clip import section_clip
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


SLOW, FAST, FASTER = Rates(issue=2, looks=1), Rates(issue=1, looks=4), Rates(issue=1, looks=8)
# What is looked at costs nothing.
SLOW_BLIND = Rates(issue=2, looks=1 << 30)


def patch_cycles(work: ShellingCounts) -> int:
    """What intersection takes."""
    return max(work.walk_cycles, 4 * work.patches)


def survival(name: str, ceiling: Ceiling) -> list[str]:
    """What codes and squares open more than distances."""
    rows, exact = [], Shelling(ceiling.geometry, CONFIG, cell=CELL)
    for clusters in 1, 8:
        sections, totals = ceiling.plan(clusters).partition.sections, []
        for shelling in (exact, *(Shelling(ceiling.geometry, CONFIG.replace({"icu.tile_bits": bits}), cell=CELL,
                                           by_code=True) for bits in (2, 3))):
            casts = [shelling.cast(ceiling.record(point), sections) for point in POINTS]
            totals.append(sum((one for _, counts in casts for one in counts), ShellingCounts()))
            if shelling is exact:
                expected = [hits for hits, _ in casts]
            elif any(len(hits.differences(other)) for (hits, _), other in zip(casts, expected, strict=True)):
                raise SystemExit(f"error: {name}: codes change the hits")
        cells, sent = ([getattr(one, field) for one in totals] for field in ("cells", "grid_rays"))
        rows.append(f"| {name} | {clusters} | {cells[0] / len(POINTS):.0f} "
                    f"| {' | '.join(f'{100 * (more / cells[0] - 1):+.1f} %' for more in cells[1:])} "
                    f"| {sent[0] / len(POINTS):.0f} "
                    f"| {' | '.join(f'{100 * (more / sent[0] - 1):+.0f} %' for more in sent[1:])} "
                    f"| {100 * (totals[1].patches / totals[0].patches - 1):+.1f} % |")
    return rows


def owned(ceiling: Ceiling, record, sections: tuple[Sector, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Grid rays and turns of each cluster if each grid ray is sent out once, by the section that it is in."""
    memory = RayMemory(len(record), CONFIG)
    tests, whole = ceiling.shelling.tests(record, memory), Sector.whole(record)
    cluster = ceiling.shelling.cluster(record, whole)
    owner = np.empty((record.rows, record.columns), dtype=np.int64)
    for number, section in enumerate(sections):
        owner[section.mask(record)] = number
    sent, turns = np.zeros((2, len(sections)), dtype=np.int64)
    for position in cluster.schedule(None, tests.window):
        seen = memory.inverse
        stage = cluster.explore(*position, seen)
        if stage is None:
            continue
        if stage.shell > 1:
            unit = CellTraversalUnit(record, ceiling.shelling.table)
            rays = unit.rays(stage.shell)
            pyramid = SettlePyramid.of(seen.reshape(owner.shape), whole, CONFIG)
            going = survivors_by_code(rays, pyramid, unit.threshold(stage.shell, CONFIG), whole, record)
            row = np.clip(rays.row_position >> INDEX_FRACTION, 0, record.rows - 1)
            of = owner[row[:, None], rays.column_position >> INDEX_FRACTION][going]
            begin, end = unit.borders(stage.shell)
            table = ceiling.shelling.table
            walk = Traversal(table.position(record.origin), global_directions(rays.direction[going], record),
                             begin=begin, end=end, shape=table.shape)
            sent += np.bincount(of, minlength=len(sections))
            # A ray that never comes to the grid takes a turn too.
            turns += np.bincount(np.delete(of, walk.ray), minlength=len(sections))
            while len(walk.ray):
                turns += np.bincount(of[walk.ray], minlength=len(sections))
                walk.advance()
        tests.run(stage, whole, ShellingCounts())
    return sent, turns


def shared(ceiling: Ceiling, record, sections: tuple[Sector, ...]) -> int:
    """Patches that more than one section sees, counted once for each section after the first."""
    window = ceiling.shelling.tests(record, RayMemory(len(record), CONFIG)).patches.window
    seen = sum((section_clip(window, section, record).rays > 0).astype(int) for section in sections)
    return int(np.maximum(seen - 1, 0).sum())


def balance(name: str, ceiling: Ceiling) -> list[str]:
    """The busiest cell traversal beside the busiest intersection."""
    rows = []
    for clusters in CLUSTERS:
        plan, pipelines = ceiling.plan(clusters), CONFIG.ctu.traversal_pipelines(clusters)
        casts = [ceiling.shelling.cast(ceiling.record(point), plan.partition.sections, plan.subshells)[1]
                 for point in POINTS]

        def worst(cycles, casts=casts):
            return np.array([max(map(cycles, counts)) for counts in casts])

        icu = worst(patch_cycles)
        turns = worst(lambda one: one.passes)
        parts = [worst(lambda one: one.scanned), worst(lambda one: 2 * one.grid_rays), -(-turns // pipelines), turns]
        designs = [worst(lambda one, rates=rates, lanes=lanes: rates.cycles(one, lanes)) for rates, lanes in (
            (SLOW_BLIND, pipelines), (SLOW, pipelines), (FAST, pipelines), (FASTER, pipelines), (FASTER, 1))]
        sent, owned_passes = (np.mean([one.max() for one in each]) for each in zip(
            *(owned(ceiling, ceiling.record(point), plan.partition.sections) for point in POINTS), strict=True))
        forwarded = np.mean([shared(ceiling, ceiling.record(point), plan.partition.sections) for point in POINTS])
        rows.append(f"| {name} | {clusters} | {pipelines} | {icu.mean():.0f} "
                    f"| {' | '.join(f'{part.mean():.0f}' for part in parts)} "
                    f"| {' | '.join(_ratio(design, icu) for design in designs)} "
                    f"| {2 * sent:.0f} | {owned_passes / pipelines:.0f} | {forwarded:.0f} |")
    return rows


def by_clusters(balances: list[str]) -> list[str]:
    """Designs B and C with the numbers of clusters side by side."""
    cells = {}
    for row in balances:
        values = [cell.strip() for cell in row.strip("|").split("|")]
        cells.setdefault(values[0], []).append(f"{values[9]}, {values[10]}")
    return [f"| {name} | {' | '.join(found)} |" for name, found in cells.items()]


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


def overlap(name: str, ceiling: Ceiling) -> list[str]:
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
            cycles = [str(cycles) for cycles, _, _ in results] + ["-"] * (len(WAYS) - len(policies))
            best = min(results, key=lambda result: result[0])
            rows.append(f"| {name} | {clusters} | {listed} | {' | '.join(cycles)} "
                        f"| {results[0][0] / best[0]:.2f} | {best[1]} |")
    return rows


def slots(name: str, ceiling: Ceiling) -> list[str]:
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
    return [f"| {name} | {first[-1]} | {every} | {' | '.join(f'{100 * (more / every - 1):+.0f} %' for more in few)} |"]


@click.command()
@click.argument("scenes", nargs=-1)
@output_option("traversal")
def main(scenes: tuple[str, ...], output: Path) -> None:
    """Compare cell traversal with intersection, cycle by cycle; SCENES default to the thesis' five."""
    ceilings = {name: Ceiling(name, CONFIG, by_code=True) for name in scenes or SCENES}
    tables = []
    for measure in survival, slots, balance, overlap:
        tables.append([row for name, ceiling in ceilings.items() for row in measure(name, ceiling)])
        console().note("\n".join(tables[-1]))
    codes, again, balances, overlaps = tables
    policies = " | ".join(f"{at_once} at once, ahead {ahead}" for at_once, ahead in WAYS)
    write_report(output, [
        "# Cell traversal", "", provenance("numpy") + ".", "",
        f"Hemispheres of {HEMISPHERE.azimuths} x {HEMISPHERE.polars} rays, cell {CELL}, from points 4, 7, 10 and 13 of "
        f"the ceiling, sections and subshells from point 1 (ratio {RATIO}). Cycles are golden's counts at the stated "
        "rates.", "",
        "## Survival by settle codes", "",
        f"{CONFIG.icu.settle_bits}-bit codes of squares of 4 x 4 and of 8 x 8 rays against exact inverse distances "
        "of single rays, in barrier order; the hits are the same. Cells and grid rays per frustum.", "",
        "| scene | clusters | cells | 4 x 4 | 8 x 8 | grid rays sent | 4 x 4 | 8 x 8 | patches found, 4 x 4 |",
        "|---" * 9 + "|", *codes, "",
        "## Slots of the ray memory", "",
        "Point 4, one cluster, subshells, barrier order: grid rays that there are, those sent with a slot for each, "
        "and how many more with so many slots (`ctu.ray_slots`).", "",
        f"| scene | grid rays | sent | {' | '.join(map(str, SLOTS))} |", "|---" * (3 + len(SLOTS)) + "|", *again, "",
        "## The busiest cell traversal beside the busiest intersection", "",
        "Mean over the points.", "",
        "* ICU: max(cycles of the window walks, 4 x patches).",
        "* Looked at: grid rays in sector and window of each shell, sent or not.",
        "* Turns: cell steps, and one for a ray that begins outside the grid for good.",
        f"* Designs, CTU : ICU, and in how many of the {len(POINTS)} frusta the CTU takes longer (bold): *A* max(2 x "
        "sent, turns / pipelines); *B* the same, and one grid ray looked at per cycle; *C* one sent and four looked at "
        "per cycle; *D* one sent and eight looked at; *E* as D with one pipeline.",
        "* One owner: each grid ray is sent by the section that it is in, and the patches found are forwarded to the "
        "other sections that see them: the busiest cluster's 2 x sent and turns / pipelines, and patches forwarded.",
        "",
        "| scene | clusters | pipelines | ICU | looked at | 2 x sent | turns / pipelines | turns | A | B | C | D | E "
        "| owner: 2 x sent | owner: turns / pipelines | forwarded |", "|---" * 16 + "|", *balances, "",
        "Designs B and C alone:", "",
        f"| scene | {' | '.join(map(str, CLUSTERS))} |", "|---" * (1 + len(CLUSTERS)) + "|",
        *by_clusters(balances), "",
        "## Overlap", "",
        f"Cycles of the busiest cluster, design C, point 4; {MEMORY} cycles from a cell to its patches and "
        f"{INTERSECTION} from there to the settle map. The hits are the same.", "",
        "* Ahead n, a run-ahead depth of n: a shell of a subshell begins when the hits of all but the n shells before "
        "it are known, and survival uses the hits known then. The first column has a barrier after each shell.",
        "* Two in flight: cycles in which two subshells or more are in flight, per cluster, in the fastest column.", "",
        f"| scene | clusters | subshells | {policies} | barrier : fastest | two in flight |",
        "|---" * (5 + len(WAYS)) + "|", *overlaps])
