"""Pearce's tables of rays that travel on a torus (4-2, 5-1, 5-2, 5-5 and 5-6), simulated.

``radiosity bench torus`` draws each of the source's lost scenes with 20 seeds and writes out/bench/torus.md: medians
beside the source's figures, the percentile at which each lies, and a grade. Nothing is set for a scene.
"""

from dataclasses import replace
from functools import cache

import numpy as np

from benchmarks.grades import BAND, grade, grade_of
from benchmarks.report import benchmark, provenance, table, write_report
from radiosity.cli.console import console
from radiosity.machines.torus.columns import Tally
from radiosity.machines.torus.ray_timing import RayTiming
from radiosity.machines.torus.torus_run import TorusSetup, simulate_torus
from radiosity.machines.torus.torus_scenes import TORUS_SCENES

__all__ = ["OPTIMA", "PASSED", "SPEEDUPS", "grade_count", "percentile", "sweep"]

# By scene: best subdivisions and tests of a ray there (table 4-2, whose third column is a ratio or an increase).
OPTIMA = {"spheres40": (5, 2.29), "barroom367": (41, 6.00), "face954": (25, 4.39)}
# By scene and nodes: speedup of workstations (table 5-1), and of the busiest and the least busy node the percentage of
# rays and the seconds (table 5-2).
SPEEDUPS = {("spheres40", 4): 1.64, ("spheres40", 9): 3.61, ("barroom367", 4): 5.11, ("barroom367", 9): 4.93,
            ("face954", 4): 6.04, ("face954", 9): 9.88}
LOADS = {("spheres40", 4): (27.2, 7139, 2994), ("spheres40", 9): (14.9, 3253, 954),
         ("barroom367", 4): (25.0, 3244, 2095), ("barroom367", 9): (14.0, 3364, 486),
         ("face954", 4): (25.3, 2855, 2134), ("face954", 9): (10.5, 1747, 755)}
# By growth: speedup (table 5-5) and rays passed (table 5-6) of the spheres on four workstations.
PASSED = {0.02: (1.64, 6910), 0.24: (3.11, 4534), 1.0: (3.63, 2199)}
# Voxels of a node along each axis, by nodes; and of the sweep of one node.
_SUBDIVISIONS, _SWEEP = {1: 32, 4: 16, 9: 8}, tuple(range(1, 98, 4))
_SEEDS, _SIZE, _SPEEDUP_SIZE, _SWEEP_SIZE = 20, (150, 150), (75, 75), (32, 32)
# us of a call that is as long, beside the rest, as on the source's workstations: they took 22.3 times the VAX' time.
_WORKSTATION_CALL = 90


def percentile(values: list[float], source: float) -> str:
    """Share of the seeds whose value is below the source's, half of those that equal it."""
    below = sum(1.0 if one < source else 0.5 if one == source else 0.0 for one in values)
    return f"{100 * below / len(values):.0f} %"


def grade_count(simulated: float, source: float, *, slack: float = 0) -> str:
    """What has become of a figure: within 15 % or a slack, within a factor of two, or neither."""
    return grade_of(abs(simulated - source) <= max(BAND * source, slack), 0.5 <= simulated / source <= 2)


@cache
def _run(name: str, seed: int, setup: TorusSetup) -> tuple[np.ndarray, np.ndarray, int, float, int]:
    """Busy seconds and walks of the nodes, rays passed, tests of a ray, rows given."""
    run = simulate_torus(TORUS_SCENES[name](seed), setup)
    tallies = run.state.tallies
    return (run.tracing / 1e6, tallies[:, Tally.TRACED].copy(), int(tallies[:, Tally.PASSED].sum()), run.tests,
            int(tallies[:, Tally.GIVEN].sum()))


def _setup(nodes: int, size: tuple[int, int], **changes) -> TorusSetup:
    return TorusSetup(nodes=nodes, subdivisions=_SUBDIVISIONS[nodes], size=size, **changes)


def _speedup(name: str, seed: int, setup: TorusSetup) -> float:
    """Time of one node over that of the busiest one."""
    alone = replace(setup, nodes=1, subdivisions=_SUBDIVISIONS[1], growth=0.02, growth_by="axis")
    return float(_run(name, seed, alone)[0].max() / _run(name, seed, setup)[0].max())


def sweep(name: str, seed: int, size: tuple[int, int], steps: tuple[int, ...]) -> tuple[int, float, float]:
    """The subdivisions with the least time on one node, tests of a ray there, and speedup over one voxel."""
    scene, found = TORUS_SCENES[name](seed), {}
    for subdivisions in steps:
        run = simulate_torus(scene, TorusSetup(nodes=1, subdivisions=subdivisions, size=size))
        found[subdivisions] = int(run.tracing[0]), run.tests
    best = min(found, key=lambda one: found[one][0])
    return best, found[best][1], found[steps[0]][0] / found[best][0]


def _optimum_rows() -> list[list]:
    rows = []
    for name, (best, tests) in OPTIMA.items():
        found = [sweep(name, seed, _SWEEP_SIZE, _SWEEP) for seed in range(_SEEDS)]
        console().note(f"{name}: {found}")
        bests, counts, ratios = (list(one) for one in zip(*found, strict=True))
        median = float(np.median(bests)), float(np.median(counts))
        rows.append([name, best, f"{median[0]:g}", percentile(bests, best), grade_count(median[0], best, slack=4),
                     f"{tests:.2f}", f"{median[1]:.2f}", percentile(counts, tests), grade_count(median[1], tests),
                     f"{np.median(ratios):.1f}"])
    return rows


def _speedup_rows() -> tuple[list[list], list[list]]:
    """Rows of speedups, and of loads."""
    rows, loads = [], []
    for (name, nodes), source in SPEEDUPS.items():
        setup = _setup(nodes, _SPEEDUP_SIZE)
        fast = _setup(nodes, _SPEEDUP_SIZE, timing=RayTiming(call=_WORKSTATION_CALL))
        found, faster = ([_speedup(name, seed, one) for seed in range(_SEEDS)] for one in (setup, fast))
        median, quick = float(np.median(found)), float(np.median(faster))
        rows.append([name, nodes, source, f"{median:.2f}", percentile(found, source),
                     grade(median / nodes, source / nodes), f"{quick:.2f}", percentile(faster, source),
                     grade(quick / nodes, source / nodes)])
        console().note(f"{rows[-1]}")
        percent, busiest, least = LOADS[name, nodes]
        shares, spreads = [], []
        for seed in range(_SEEDS):
            busy, walks = _run(name, seed, fast)[:2]
            shares.append(100 * float(walks[busy.argmax()] / walks.sum()))
            spreads.append(float(busy.max() / busy.min()))
        share, spread = float(np.median(shares)), float(np.median(spreads))
        loads.append([name, nodes, percent, f"{share:.1f}", percentile(shares, percent),
                      grade(share * nodes / 100, percent * nodes / 100), f"{busiest / least:.2f}", f"{spread:.2f}",
                      percentile(spreads, busiest / least), grade(spread, busiest / least)])
    return rows, loads


def _growth_rows() -> list[list]:
    rows = []
    for by in ("axis", "volume"):
        for growth, (speedup, passed) in PASSED.items():
            setup = _setup(4, _SIZE, growth=growth, growth_by=by, timing=RayTiming(call=_WORKSTATION_CALL))
            base = replace(setup, growth=0.02)
            runs = [(_run("spheres40", seed, setup), _run("spheres40", seed, base)) for seed in range(_SEEDS)]
            found = [_speedup("spheres40", seed, setup) for seed in range(_SEEDS)]
            counts, shares = [one[2] for one, _ in runs], [one[2] / first[2] for one, first in runs]
            share = passed / PASSED[0.02][1]
            median = [float(np.median(values)) for values in (found, counts, shares)]
            rows.append([by, f"{100 * growth:.0f} %", speedup, f"{median[0]:.2f}", percentile(found, speedup),
                         grade(median[0] / 4, speedup / 4), passed, f"{median[1]:.0f}", percentile(counts, passed),
                         grade_count(median[1], passed), f"{share:.3f}", f"{median[2]:.3f}",
                         percentile(shares, share), grade(median[2], share), max(one[4] for one, _ in runs)])
            console().note(f"{rows[-1]}")
    return rows


@benchmark("torus")
def main() -> None:
    """Simulate tables 4-2, 5-1, 5-2, 5-5 and 5-6 of Pearce's thesis."""
    (speedups, loads), growths, optima = _speedup_rows(), _growth_rows(), _optimum_rows()
    write_report(
        "Rays that travel on a torus, simulated",
        f"{provenance('numpy')}; medians of {_SEEDS} seeds; {_SIZE[0]} x {_SIZE[1]} pixels for growth, "
        f"{_SPEEDUP_SIZE[0]} x {_SPEEDUP_SIZE[1]} for speedups, {_SWEEP_SIZE[0]} x {_SWEEP_SIZE[1]} for best v; "
        "profile 1987; percentiles are shares of the seeds below the source's figure.",
        table(["scene", "best v", "simulated v", "percentile", "grade", "tests of a ray", "simulated tests",
               "percentile of tests", "grade of tests", "speedup over one voxel"], optima),
        table(["scene", "nodes", "speedup", "simulated", "percentile", "grade",
               f"calls of {_WORKSTATION_CALL} us", "percentile of calls", "grade of calls"], speedups),
        table(["scene", "nodes", "% of rays of the busiest node", "simulated", "percentile", "grade",
               "busiest : least busy", "simulated ratio", "percentile of ratio", "grade of ratio"], loads),
        table(["growth by", "growth", "speedup", "simulated", "percentile", "grade", "rays passed",
               "simulated rays", "percentile of rays", "grade of rays", "of 2 %", "simulated share",
               "percentile of share", "grade of share", "rows given at most"], growths))
