"""Daylight and electric light whose illuminance is known, as the renderer measures it.

``radiosity bench daylight`` measures sky components behind unglazed openings, reflections in a cube, lamps above a
plane, and panes, in the manner of CIE 171:2006. The truth is a closed form, or quadrature of a definition.
"""

from benchmarks.daylight_cases import CASES
from benchmarks.report import benchmark, provenance, table, write_report
from radiosity.cli.console import console


@benchmark("daylight")
def main() -> None:
    """Compare measured illuminances with the truth."""
    rows, largest = [], 0.0
    for name, measure in CASES.items():
        for case in measure():
            difference = round(100 * case.error, 2) + 0.0
            rows.append([case.name, f"{case.truth:.5g}", f"{case.found:.5g}", f"{difference:+.2f} %"])
            largest = max(largest, abs(case.error))
        console().note(name)
    write_report("Daylight and lamps", f"{provenance('numpy', 'scipy')}.",
                 table(["what", "truth", "measured", "difference"], rows), f"Largest difference: {largest:.2%}.")
