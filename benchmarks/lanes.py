"""Ray lanes: what several ray pipelines behind one patch setup would bring, and what they would take.

``radiosity bench lanes`` simulates one hemisphere from each scene's ceiling on a cluster whose window walk issues one
ray of a tile in a cycle, as the hardware does, and on one that issues several. It writes out/bench/lanes.md. Beside the
cycles it has the recorded area of the units that each further lane repeats.
"""

from benchmarks.engine import POINT, SCENES, machine_config
from benchmarks.machines import SceneCasts
from benchmarks.report import benchmark, provenance, table, write_report
from golden.engine.schedule.cell_choice import CELLS
from radiosity.cli.console import console
from radiosity.flow.synthesis.history import last_records, read_history
from radiosity.machines.engine.simulated_cast import SimulatedCast

__all__ = ["REPEATED", "added_area", "row_of"]

# Units of the ray pipeline that each lane has. A memory of rays would have as many banks as there are lanes, of less
# depth each.
REPEATED = ("RayIssue", "RayDirection", "Screening", "InverseDistance", "UvAlignment", "UvSubdivision")
_CANDIDATES = CELLS[:3]
_LANES, _SIZES = 2, ((64, 16), (128, 32))


def row_of(scene: str, one: SimulatedCast, several: SimulatedCast, rays: tuple[int, int], lanes: int) -> list:
    """A row of the table: an efficiency is tests over cycles and lanes."""
    cycles = one.times.cycles, several.times.cycles
    return [f"`{scene}`", rays[0] * rays[1], f"{one.tests:,}", f"{cycles[0]:,}", f"{one.tests / cycles[0]:.3f}",
            f"{cycles[1]:,}", f"{several.tests / cycles[1] / lanes:.3f}", f"{cycles[0] / cycles[1]:.2f}"]


def added_area(lanes: int) -> list[list]:
    """Rows of the recorded areas of `REPEATED` in preset ``small`` on an ECP5, and their sum for all further lanes."""
    known = last_records(read_history())
    records = [known["ecp5", "small", "", "icu", unit] for unit in REPEATED]
    areas = [(one.lut, one.ff, one.dsp, one.bram) for one in records]
    total = [(lanes - 1) * sum(column) for column in zip(*areas, strict=True)]
    rows = [[f"`{one.unit}`", *area, one.commit] for one, area in zip(records, areas, strict=True)]
    return [*rows, [f"{lanes - 1} more of each", *total, ""]]


@benchmark("lanes", SCENES)
def main(scenes) -> None:
    """Simulate ray lanes; SCENES default to cornell, lobby, room1627, tetra and man."""
    rows = []
    for rays in _SIZES:
        config = machine_config("paper", (), rays)
        for scene in scenes:
            casts = SceneCasts(scene, config, rays=rays)
            one, several = (min((casts.cast(cell, lanes=count) for cell in _CANDIDATES),
                                key=lambda cast: cast.times.cycles) for count in (1, _LANES))
            rows.append(row_of(scene, one, several, rays, _LANES))
            console().note(" ".join(map(str, rows[-1])))
    write_report(
        "Ray lanes, simulated",
        f"{provenance('numpy')}; preset paper, one cluster, a hemisphere from point "
        f"{POINT} of the ceiling, the best of the cells {', '.join(f'{cell:g}' for cell in _CANDIDATES)} for each.",
        table(["scene", "rays", "tests", "cycles, 1 lane", "efficiency", f"cycles, {_LANES} lanes",
               "efficiency of lanes", "gain"], rows),
        "What a further lane repeats, preset small on an ECP5:",
        table(["unit", "LUT", "FF", "DSP", "block RAM", "commit"], added_area(_LANES)))
