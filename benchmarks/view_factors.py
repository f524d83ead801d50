"""View factors: requested and real errors, closure and reciprocity, beside pyViewFactor and raystrack.

``radiosity bench view_factors -o out/bench/view-factors.md`` computes facets with known view factors, facets that hide
each other among them, over several seeds; then built-in scenes; then some of both by the other programs too, as far as
they are installed (extra ``compare``). All figures but seconds and memory depend on the versions of packages alone.
"""

import time

import click
import numpy as np
from scipy.special import erf

from benchmarks.report import benchmark, page_path, provenance, table, write_chart, write_report
from benchmarks.view_factor_cases import BARRIER, HIDDEN, OPEN, Case, box_in_box, plate_between_plates
from benchmarks.view_factor_methods import method_rows
from benchmarks.view_factor_programs import PROGRAMS, compute, in_own_process
from golden.base.peak_memory import peak_memory
from golden.cast.grid import Grid
from golden.light.factors.compute import compute_view_factors
from golden.light.factors.interface import view_factors
from golden.light.factors.rows import FactorRows
from golden.light.factors.view_factors import ViewFactors
from golden.scene.open import open_scene
from golden.scene.scene import Scene
from radiosity.charts.chart import Line
from radiosity.cli.console import console

OPEN_ERRORS, HIDDEN_ERRORS = (1e-2, 1e-3, 1e-5), (1e-2, 1e-3)
SEEDS = 20
SCENE_ERROR, CITY_ERROR, CLOSED_ERRORS = 1e-2, 1e-3, (2e-2, 1e-3)
PROGRAM_SECONDS = 180.0
MIB = 1 << 20


# The multiples of the standard error within which factors are counted, and of plates that hide a part the widths.
WITHIN = (1, 2, 3, 4)
COVERED_WIDTHS = tuple(k / 10 for k in range(1, 10))


def largest_error(case: Case, found: ViewFactors) -> float:
    """Largest difference of a case's factors from what is known."""
    return case.largest_error(found.F, found.sky, found.area)


def open_rows() -> list[list]:
    """Of each case without occlusion its largest errors, by requested error."""
    rows = []
    for make in OPEN:
        case = make()
        rows.append([case.name, len(case.facets), *(
            small(largest_error(case, view_factors(case.facets, error=error))) for error in OPEN_ERRORS)])
        console().note(rows[-1][0])
    return rows


def hidden_rows(seeds: int) -> list[list]:
    """Of each case with occlusion by requested error: median and largest error, and the share of seeds within it."""
    rows = []
    for make in HIDDEN:
        case = make()
        for error in HIDDEN_ERRORS:
            found = np.array([largest_error(case, view_factors(case.facets, error=error, seed=seed))
                              for seed in range(seeds)])
            rows.append([case.name, len(case.facets), f"{error:g}", small(np.median(found)), small(max(found)),
                         f"{np.mean(found <= error):.0%}"])
        console().note(case.name)
    return rows


def measured_deviations(seeds: int) -> dict[tuple[str, float], np.ndarray]:
    """By name and requested error the deviations of known factors of pairs that see a part of each other."""
    plates = [plate_between_plates(width) for width in COVERED_WIDTHS]
    cases = [(f"plates of {len(plates)} widths between unit squares", plates, error) for error in HIDDEN_ERRORS]
    barrier = BARRIER()
    cases += [(barrier.name, [barrier], error) for error in HIDDEN_ERRORS]
    return {(name, error): np.concatenate([
        case.deviations(view_factors(case.facets, error=error, seed=seed)) for case in some for seed in range(seeds)])
        for name, some, error in cases}


def coverage_rows(deviations: dict[tuple[str, float], np.ndarray]) -> list[list]:
    """The shares of deviations within some standard errors, of each and of all together."""
    everything = {**deviations, ("all", ""): np.concatenate(list(deviations.values()))}
    return [[*name, len(values), *(f"{np.mean(np.abs(values) <= within):.0%}" for within in WITHIN)]
            for name, values in everything.items()]


def write_coverage(deviations: dict[tuple[str, float], np.ndarray]) -> None:
    """A chart of the share of deviations within each multiple of the standard error, beside the normal distribution."""
    x = np.linspace(0, 4, 201)
    measured = np.abs(np.concatenate(list(deviations.values())))
    lines = [Line(name="normal distribution", x=x, y=erf(x / np.sqrt(2))),
             Line(name="measured", x=x, y=(measured <= x[:, None]).mean(axis=1))]
    write_chart(f"{page_path().stem}-coverage", lines, title=f"{len(measured)} factors that are known",
                x_name="standard errors", y_name="share within", y_top=1.05)


def scene_figures(name: str, error: float) -> dict:
    """Figures of a scene's view factors; the process has had no other one."""
    begin, busy = time.perf_counter(), time.process_time()
    scene = open_scene(name)
    found = compute_view_factors(FactorRows(scene, Grid(scene), error=error))
    return {"rows": len(found), "entries": found.F.nnz, "closure": small(found.closure),
            "reciprocity": small(found.reciprocity), "error": f"{found.largest_error:.2g}",
            "largest change": f"{found.largest_change:.2g}", "sky error": f"{found.largest_sky_error:.2g}",
            "sky change": f"{found.sky_change:.2g}", "open rows": len(found.infeasible),
            "s": f"{time.perf_counter() - begin:.1f}", "CPU s": f"{time.process_time() - busy:.1f}",
            "MiB": f"{peak_memory() / MIB:.0f}"}


def scene_table(names: tuple[str, ...], error: float) -> list[str]:
    """Lines of a table with a row for each scene."""
    rows = []
    for name in names:
        found = in_own_process(scene_figures, name, error)
        rows.append([name, *found.values()])
        console().note(name)
    return table(["scene", *found], rows)


def compared() -> list[tuple[str, np.ndarray, Case | None, float]]:
    """What all programs compute: a name, facets, what is known of them, and the requested error."""
    cases = [plate_between_plates(), box_in_box(0.6, 4)]
    return [*((case.name, case.facets, case, 1e-3) for case in cases),
            ("fronts of lobby", open_scene("lobby").vertices, None, SCENE_ERROR)]


def program_rows(name: str, facets: np.ndarray, case: Case | None, error: float, seconds: float) -> list[list]:
    """A row for each program, which says so if the program is stopped after so many seconds."""
    rows, area = [], Scene.from_arrays(facets).areas
    for program in PROGRAMS:
        try:
            found = in_own_process(compute, program, facets, error, seconds=seconds)
        except TimeoutError:
            rows.append([name, len(facets), program, f"stopped after {seconds:g} s", *[""] * 5])
            continue
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


@benchmark("view-factors", ("lobby", "room1627"))
@click.option("--error", type=float, default=SCENE_ERROR, help="Set the requested error of the scenes.")
@click.option("--seeds", type=click.IntRange(1), default=SEEDS, help="Set the number of seeds of facets that hide each "
              "other.")
@click.option("--city", is_flag=True, help="Also compute the scene city to an error of 0.001, which takes minutes.")
def main(scenes: tuple[str, ...], error: float, seeds: int, city: bool) -> None:
    """Compare view factors with known ones and with other programs; SCENES default to lobby and room1627."""
    deviations, closed = measured_deviations(seeds), box_in_box(0.6, 2).facets
    write_coverage(deviations)
    methods = method_rows(closed, coarse=CLOSED_ERRORS[0], fine=CLOSED_ERRORS[1])
    parts = ["## Closed forms", "Largest error, by requested error.",
             table(["facets", "count", *(f"{one:g}" for one in OPEN_ERRORS)], open_rows()),
             "## Facets that hide each other", f"Over {seeds} seeds.",
             table(["facets", "count", "requested", "median", "largest", "seeds within"], hidden_rows(seeds)),
             "## Coverage of the estimated errors", f"Over {seeds} seeds, within so many standard errors.",
             table(["facets", "requested", "factors", *WITHIN], coverage_rows(deviations)),
             "## Methods of closure", f"Cube in a cube, {len(closed)} facets, requested error {CLOSED_ERRORS[0]:g}, "
             f"compared with {CLOSED_ERRORS[1]:g}.",
             table(["method", "closure", "below 0", "exact factors move by", "RMS error"],
                   [[name, small(closure), below, small(moved), small(wrong)]
                    for name, closure, below, moved, wrong in methods]),
             "## Scenes", f"Requested error {error:g}.", scene_table(scenes, error)]
    if city:
        parts += ["## A city", f"Requested error {CITY_ERROR:g}.", scene_table(("city",), CITY_ERROR)]
    write_report(
        "View factors", f"{provenance('numpy', 'scipy')}; method grid.", *parts,
        "## Other programs", "Seconds of compiled code, and peak memory of the process.",
        table(["facets", "count", "program", "error", "closure", "row sums", "reciprocity", "s", "MiB"],
              [row for one in compared() for row in program_rows(*one, PROGRAM_SECONDS)]))
