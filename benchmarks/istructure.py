"""What each part between a cluster and the patches that it does not hold is worth: cycles, traffic and area.

``radiosity bench istructure`` simulates machines of preset ``paper`` on which each cluster casts a hemisphere of its
own, with resident sets of several sizes, and with a patch store whose presence bits defer requests, or block, or that
has one request in flight, with none, and without a network. It writes out/bench/istructure.md and a chart for each
number of clusters. Areas are those of docs/figures/history.csv. With ``--sizes`` it compares sizes of the resident
set and of the patch store instead, of scenes that one cluster does not hold. With ``--calibrate`` it simulates what
docs/figures/istructure-cycles.csv has of the hardware, and with ``--hardware`` the hardware casts it again.
"""

from dataclasses import fields
from functools import cache

import click
import numpy as np
from click.core import ParameterSource

from benchmarks.grades import signed
from benchmarks.path_area import area_table, equal_area_table, path_area
from benchmarks.recorded import check_recorded
from benchmarks.report import benchmark, cell_text, provenance, table, write_chart, write_report
from benchmarks.shared_hardware import cast_rows, recorded_rows, simulated_rows
from benchmarks.shared_scene import LATENCY, Access, Outcome, Placement, SharedScene
from golden.base.errors import InputError
from radiosity.charts.chart import Line
from radiosity.cli.console import console

__all__ = ["SCENES", "SHARES", "outcomes_of", "relative"]

SCENES = ("lobby", "room1627", "cubes", "man", "phone", "city:4")
# Shares of a scene's patches that a cluster has memory for.
SHARES = {"1/8": 1 / 8, "1/4": 1 / 4, "1/2": 1 / 2}
_ALL, _CLUSTERS = "all", (1, 4, 16)
# Sizes that are compared: patches of a cluster's resident set and of its store. The first one is what others count by.
SIZES = ((1024, 128), (1024, 1024), (2048, 128))
_COUNTS = ("own memory", "store", "other clusters", "cache", "main memory", "deferred", "flits")

# By sets, share and path.
Outcomes = dict[tuple[Placement, str, Access], Outcome]


def outcomes_of(scene: SharedScene, clusters: int, shares: tuple[str, ...] = tuple(SHARES)) -> Outcomes:
    """The outcomes of all sets and paths; where every cluster holds all patches nothing is requested on any path."""
    @cache
    def outcome(home, access):
        return scene.outcome(clusters, np.frombuffer(home, dtype=np.int64).reshape(clusters, -1), access)

    everywhere = outcome(scene.home(clusters, Placement.EVERYWHERE, 1).tobytes(), Access.NETWORK)
    found = {(Placement.EVERYWHERE, _ALL, access): everywhere for access in Access}
    for placement in Placement.DEALT, Placement.DISCOVERY:
        for name in shares:
            home = scene.home(clusters, placement, SHARES[name]).tobytes()
            found |= {(placement, name, access): outcome(home, access) for access in Access}
    return found


def sized_cycles(scene: SharedScene, clusters: int) -> list[float]:
    """Cycles by `SIZES`; clusters that can hold all patches do."""
    return [scene.outcome(clusters, scene.home(
        clusters, Placement.DEALT if own < scene.patches else Placement.EVERYWHERE, min(1, own / scene.patches)),
        Access.DEFERRAL, frames=frames).cycles for own, frames in SIZES]


def relative(found: list[Outcomes], placement: Placement, share: str, access: Access) -> float:
    """Cycles over those of clusters that hold all patches: the geometric mean of scenes."""
    return float(np.exp(np.mean([
        np.log(one[placement, share, access].cycles / one[Placement.EVERYWHERE, _ALL, access].cycles)
        for one in found])))


def _rows(name, scene, clusters, found):
    """All outcomes of a scene on so many clusters, with the area of what differs."""
    for (placement, share, access), one in found.items():
        if share == _ALL and access is not Access.DEFERRAL:
            continue
        area = path_area(scene.patches if share == _ALL else int(np.ceil(SHARES[share] * scene.patches)),
                         frames=scene.frames, access=access, clusters=clusters)
        yield [f"`{name}`", clusters, placement.value, share, access.value if share != _ALL else "any",
               *(f"{getattr(one, field.name):.0f}" for field in fields(Outcome)),
               *(area if area else ("", ""))]


def _summary(found):
    """Rows by clusters, sets and share: cycles of each path over those of clusters that hold all patches."""
    return [[clusters, share, placement.value, *(f"{relative(list(each.values()), placement, share, access):.3f}"
                                                 for access in Access)]
            for clusters, each in found.items() for share in SHARES
            for placement in (Placement.DEALT, Placement.DISCOVERY)]


def _scene_rows(scenes, found, share):
    """Of each scene with dealt sets of a share: the most clusters, cycles by path, and traffic of one frustum."""
    clusters = max(found)
    for name, one in found[clusters].items():
        all_held = one[Placement.EVERYWHERE, _ALL, Access.DEFERRAL].cycles
        deferral = one[Placement.DEALT, share, Access.DEFERRAL]
        yield [f"`{name}`", scenes[name].patches, f"{scenes[name].cell:g}", scenes[name].frames, f"{all_held:.0f}",
               *(f"{one[Placement.DEALT, share, access].cycles:.0f}" for access in Access),
               *(f"{count:.0f}" for count in (deferral.kept, deferral.deferred, deferral.flits, deferral.misses))]


def _calibration(recorded, hardware):
    """A table: recorded cycles of the hardware, or those that it takes now, beside simulated ones."""
    rows = []
    taken = {row: round(cycles) for row, cycles in cast_rows(recorded)} if hardware else {}
    for row, simulated in simulated_rows(recorded):
        cycles = taken.get(row, row.cycles)
        rows.append([f"`{row.scene}`", row.clusters, row.sets, f"{row.share:g}", row.store or "none",
                     row.requests if row.store else "", f"{cycles:,}", f"{simulated:,.0f}",
                     signed(simulated / cycles - 1)])
    return table(["scene", "clusters", "sets", "share", "store", "requests", "cycles", "simulated", "error"], rows)


def _size_table(scenes, clusters):
    """Of each scene with more patches than a resident set, and each number of clusters: cycles by sizes."""
    rows = []
    for name, scene in scenes.items():
        for count in clusters if scene.patches > SIZES[0][0] else ():
            first, *others = sized_cycles(scene, count)
            rows.append([f"`{name}`", scene.patches, count, f"{first:.0f}", *(f"{one / first:.3f}" for one in others)])
            console().note(f"{name}, {count} clusters: simulated")
    return table(["scene", "patches", "clusters", *(f"{own} and {frames}" for own, frames in SIZES)], rows)


def _chart(found, clusters):
    """Cycles of each path against the share of the patches that a cluster has memory for."""
    shares = np.array([*SHARES.values(), 1])
    lines = [Line(name=access.value, x=shares, y=np.array(
        [*(relative(list(found.values()), Placement.DEALT, share, access) for share in SHARES), 1]))
        for access in Access]
    write_chart(
        f"istructure-{clusters}", lines, title=f"{clusters} clusters: cycles, with all patches in each cluster 1",
        x_name="share of the patches in a cluster", y_name="cycles",
        y_top=1.05 * max(float(line.y.max()) for line in lines))


@benchmark("istructure")
@click.argument("scenes", nargs=-1)
@click.option("--clusters", type=click.IntRange(1, 16), multiple=True, default=_CLUSTERS, show_default=True,
              help="Simulate this many clusters, a power of two; may be repeated.")
@click.option("--sizes", is_flag=True, help="Compare sizes of resident sets and patch stores instead.")
@click.option("--calibrate", is_flag=True, help="Compare with all recorded cycles of the hardware instead.")
@click.option("--hardware", is_flag=True, help="With --calibrate, have the hardware cast again: many minutes.")
def main(scenes, clusters, sizes, calibrate, hardware) -> None:
    """Compare paths to patches that a cluster does not hold; SCENES default to those of the thesis, and city."""
    if hardware and not calibrate:
        raise InputError("--hardware needs --calibrate")
    if calibrate:
        for option in ("clusters", "sizes"):
            if click.get_current_context().get_parameter_source(option) is ParameterSource.COMMANDLINE:
                raise InputError(f"--{option} does not go with --calibrate, whose machines are recorded")
        recorded = recorded_rows()
        check_recorded("istructure", scenes, [row.scene for row in recorded])
        recorded = [row for row in recorded if not scenes or row.scene in scenes]
        write_report("Machines that share a scene, simulated and of the hardware", f"{provenance('numpy')}.",
                     _calibration(recorded, hardware))
        return
    made, clusters = {name: SharedScene(name) for name in dict.fromkeys(scenes or SCENES)}, sorted({*clusters})
    conditions = (
        f"{provenance('numpy')}; preset paper, a hemisphere of 256 x 64 rays for each cluster, {cell_text(None)}, main "
        f"memory {LATENCY} cycles away, stores with what the frustum before has left.")
    if sizes:
        write_report("Sizes of resident sets and patch stores", conditions,
                     "Cycles by patches of a cluster's resident set and of its store, those of the second and third "
                     "sizes over those of the first one:", _size_table(made, clusters))
        return
    found = {}
    for count in clusters:
        for name, scene in made.items():
            found.setdefault(count, {})[name] = outcomes_of(scene, count)
            console().note(f"{name}, {count} clusters: simulated")
        _chart(found[count], count)
    rows = [row for count, each in found.items() for name, one in each.items()
            for row in _rows(name, made[name], count, one)]
    first, most = next(iter(SHARES)), max(found)
    write_report(
        "What the parts of the path are worth", conditions,
        "Cycles over those of clusters that hold all patches, geometric means of the scenes:",
        table(["clusters", "share", "sets", *(access.value for access in Access)], _summary(found)),
        f"Cycles of {most} clusters with dealt sets of {first}, and of a frustum with deferral patches from the store, "
        "deferred requests, flits, and reads of main memory:",
        table(["scene", "patches", "cell", "frames", "all held", *(access.value for access in Access), "store",
               "deferred", "flits", "reads"], list(_scene_rows(made, found, first))),
        "Area:", area_table(),
        "Area of a cluster that holds all patches, and of one of eight that hold them together:", equal_area_table(),
        "All outcomes, means of a cluster and its frustum:",
        table(["scene", "clusters", "sets", "share", "path", "cycles", *_COUNTS, "LUT", "block RAM"], rows))
