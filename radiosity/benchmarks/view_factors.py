"""View factors: requested and real errors, closure and reciprocity, beside pyViewFactor and raystrack.

``radiosity bench view_factors -o out/bench/view-factors.md`` computes facets with known view factors, facets that hide
each other among them, over several seeds; then built-in scenes; then some of both by the other programs too, as far as
they are installed (extra ``compare``). All figures but seconds and memory depend on the versions of packages alone.
"""

import time
from pathlib import Path

import click
import numpy as np

from golden.cast.grid import Grid
from golden.commands.console import console
from golden.light.factors.compute import compute_view_factors
from golden.light.factors.interface import view_factors
from golden.light.factors.meshes import geometry_scene
from golden.light.factors.rows import FactorRows
from golden.peak_memory import peak_memory
from golden.scene.open import open_scene
from radiosity.benchmarks.report import output_option, provenance, table, write_report
from radiosity.benchmarks.view_factor_cases import HIDDEN, OPEN, Case, box_in_box, plate_between_plates
from radiosity.benchmarks.view_factor_programs import PROGRAMS, compute, in_own_process

OPEN_ERRORS, HIDDEN_ERRORS = (1e-2, 1e-3, 1e-5), (1e-2, 1e-3)
SEEDS = 20
SCENE_ERROR = 1e-2
MIB = 1 << 20


def largest_error(case: Case, *, error: float, seed: int = 0) -> float:
    """Largest difference of a case's factors from what is known."""
    found = view_factors(case.facets, error=error, seed=seed)
    return case.largest_error(found.F, found.sky, found.area)


def open_rows() -> list[list]:
    """Of each case without occlusion its largest errors, by requested error."""
    rows = []
    for make in OPEN:
        case = make()
        rows.append([case.name, len(case.facets), *(small(largest_error(case, error=error)) for error in OPEN_ERRORS)])
        console().note(rows[-1][0])
    return rows


def hidden_rows(seeds: int) -> list[list]:
    """Of each case with occlusion its largest and its median error, and the share within, by requested error."""
    rows = []
    for make in HIDDEN:
        case = make()
        for error in HIDDEN_ERRORS:
            found = [largest_error(case, error=error, seed=seed) for seed in range(seeds)]
            rows.append([case.name, len(case.facets), f"{error:g}", small(np.median(found)), small(max(found)),
                         f"{np.mean(np.array(found) <= error):.0%}"])
        console().note(rows[-1][0])
    return rows


def scene_figures(name: str, error: float) -> dict:
    """Figures of a scene's view factors; the process has had no other one."""
    begin = time.perf_counter()
    scene = open_scene(name)
    found = compute_view_factors(FactorRows(scene, Grid(scene), error=error))
    return {"rows": len(found), "entries": found.F.nnz, "closure": found.closure, "reciprocity": found.reciprocity,
            "error": found.largest_error, "change": found.largest_change, "sky_change": found.sky_change,
            "infeasible": len(found.infeasible), "seconds": time.perf_counter() - begin, "memory": peak_memory()}


def scene_row(name: str, error: float) -> list:
    """The row of a scene."""
    found = in_own_process(scene_figures, name, error)
    console().note(name)
    return [name, found["rows"], found["entries"], small(found["closure"]), small(found["reciprocity"]),
            f"{found['error']:.2g}", f"{found['change']:.2g}", f"{found['sky_change']:.2g}", found["infeasible"],
            f"{found['seconds']:.1f}", f"{found['memory'] / MIB:.0f}"]


def compared() -> list[tuple[str, np.ndarray, Case | None, float]]:
    """What all programs compute: a name, facets, what is known of them, and the requested error."""
    cases = [plate_between_plates(), box_in_box(0.6, 4)]
    return [*((case.name, case.facets, case, 1e-3) for case in cases),
            ("fronts of lobby", open_scene("lobby").vertices, None, SCENE_ERROR)]


def program_rows(name: str, facets: np.ndarray, case: Case | None, error: float) -> list[list]:
    """A row for each program."""
    rows, area = [], geometry_scene(facets).areas
    for program in PROGRAMS:
        found = in_own_process(compute, program, facets, error)
        if found is None:
            rows.append([name, len(facets), program, "not installed", *[""] * 5])
            continue
        sums, exchange = found.F.sum(axis=1), found.F * area[:, None]
        missed = "" if found.sky is None else small(np.abs(sums + found.rest + found.sky - 1).max())
        wrong = "" if case is None else small(case.largest_error(found.F, found.sky, area))
        rows.append([name, len(facets), program, wrong, missed, f"{sums.min():.3f} to {sums.max():.3f}",
                     small(np.abs(exchange - exchange.T).sum() / exchange.sum()), f"{found.seconds:.2f}",
                     f"{found.memory / MIB:.0f}"])
        console().note(f"{name}: {program}")
    return rows


def small(value: float) -> str:
    """A share with two digits; what is rounding on any machine is below 1e-9."""
    return "< 1e-9" if value < 1e-9 else f"{value:.1e}"


@click.command()
@click.argument("scenes", nargs=-1)
@click.option("--error", type=float, default=SCENE_ERROR, help="Set the requested error of the scenes.")
@click.option("--seeds", type=click.IntRange(1), default=SEEDS, help="Set the number of seeds of facets that hide each "
              "other.")
@click.option("--programs/--no-programs", default=True, help="Choose whether other programs run.")
@output_option("view-factors")
def main(scenes: tuple[str, ...], error: float, seeds: int, programs: bool, output: Path) -> None:
    """Compare view factors with known ones and with other programs; SCENES default to lobby and room1627."""
    lines = ["# View factors", "", f"{provenance('numpy', 'scipy')}; method grid.", "", "## Closed forms", "",
             "Largest error, by requested error.", "",
             *table(["facets", "count", *(f"{one:g}" for one in OPEN_ERRORS)], open_rows()), "",
             "## Facets that hide each other", "", f"Over {seeds} seeds.", "",
             *table(["facets", "count", "requested", "median", "largest", "seeds within"], hidden_rows(seeds)), "",
             "## Scenes", "", f"Requested error {error:g}.", "",
             *table(["scene", "rows", "entries", "closure", "reciprocity", "error", "largest change", "sky change",
                     "open rows", "s", "MiB"], [scene_row(name, error) for name in scenes or ("lobby", "room1627")])]
    if programs:
        rows = [row for one in compared() for row in program_rows(*one)]
        lines += ["", "## Other programs", "", "Seconds of compiled code, and peak memory of the process.", "",
                  *table(["facets", "count", "program", "error", "closure", "row sums", "reciprocity", "s", "MiB"],
                         rows)]
    write_report(output, lines)
