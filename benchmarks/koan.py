"""The tables and figures of the report on KOAN (tables 3 and 4, figure 7), simulated.

``radiosity bench koan`` makes pictures of stand-ins for the source's scenes, of 512 x 512 pixels, on machines of 2 to
64 nodes. One number of its timing is fitted, on Teapot in table 4; for table 3 a second one. It writes
out/bench/koan.md: seconds beside the source's, and its statements, each with a grade. Nothing is set for a scene.
"""

from dataclasses import replace

import numpy as np
from scipy.optimize import lsq_linear

from benchmarks.grades import grade_of, signed
from benchmarks.koan_scenes import KOAN_SCENES, koan_scene
from benchmarks.koan_times import TABLE_3, TABLE_4, closed_3, closed_4, errors
from benchmarks.report import benchmark, provenance, table, write_report
from radiosity.cli.console import console
from radiosity.machines.koan.koan_machine import KoanMachine
from radiosity.machines.koan.page_timing import PageTiming
from radiosity.machines.koan.pixel_items import PixelItems, pixel_items
from radiosity.machines.koan.ray_pages import PageString
from radiosity.machines.koan.scene_pages import ScenePages

__all__ = ["fit", "referred_pages", "saturation"]

_SIZE, _SMALL = (512, 512), (128, 128)
_CACHE, _MEMORY = 2 << 20, 3_200_000
# Of rings4, whose one node's time the source does not have: that of 32 nodes without their faults.
_ALONE = {"Teapot": 5927, "Mountain": 11042, "Rings4": 704 * 32 - 0.011 * 1158 * 31}
_CACHES, _CACHE_NODES, _ENOUGH = (64, 128, 204, 256, 512, 1024, 2048), 16, 0.5
_SIDES = (1, 2, 3, 4, 8, 16)


def fit(seconds, sources: dict[int, float], numbers: list[PageTiming]) -> np.ndarray:
    """The weights of timings, at least 0, by which their seconds above those of the first come nearest to the source's.

    Parameters
    ----------
    seconds
        Function from a timing to seconds by numbers of nodes.
    sources
        Seconds by numbers of nodes.
    numbers
        A timing with the least of all numbers, and one with each that is fitted.
    """
    found = [seconds(one) for one in numbers]
    times = np.array([[one[nodes] / time for nodes, time in sources.items() if nodes > 1] for one in found])
    return lsq_linear((times[1:] - times[0]).T, 1 - times[0], bounds=(0, np.inf)).x


def saturation(efficiencies: dict[int, float]) -> float:
    """The cache in pages, by interpolation in its logarithm, at which the efficiency falls below one half.

    0 if it does in none, infinite if it does in all.
    """
    pages = np.array(sorted(efficiencies))
    values = np.array([efficiencies[one] for one in pages])
    if (values < _ENOUGH).all():
        return float("inf")
    above = int(np.argmax(values >= _ENOUGH))
    if above == 0:
        return 0.0
    low, high = np.log(pages[above - 1:above + 1])
    share = (_ENOUGH - values[above - 1]) / (values[above] - values[above - 1])
    return float(np.exp(low + share * (high - low)))


def _frames(name: str, machine: KoanMachine, page_bytes: int, cache: float) -> int:
    """Frames of a cache as large a share of our scene's pages as the source's of its scene's."""
    layout, _ = machine.string(page_bytes)
    return max(1, int(cache * layout.size / (KOAN_SCENES[name].kilobytes << 10) / page_bytes))


def _table_4(machines):
    """The fitted timing; seconds and faults by scene and nodes; and rows of the table."""
    faults = {name: {} for name in machines}

    def times(name, timing):
        runs = {nodes: machines[name].run(nodes=nodes, timing=timing, alone=_ALONE[name], frames=_frames(
            name, machines[name], 4096, _CACHE)) for nodes in TABLE_4[name] if nodes > 1}
        faults[name] = {nodes: run.report()["faults"] for nodes, run in runs.items()}
        return {nodes: run.time / 1e9 for nodes, run in runs.items()}

    least, one = PageTiming(trap=0, serve=0), PageTiming(trap=1_000_000, serve=1_000_000)
    weight = float(fit(lambda timing: times("Teapot", timing), TABLE_4["Teapot"], [least, one])[0])
    number = round(weight * 1e6 / 1e5) * 100_000
    timing = PageTiming(trap=number, serve=number)
    console().note(f"trap and serve: {number} ns")
    seconds, rows = {name: times(name, timing) for name in machines}, []
    for name in ("Teapot", "Mountain"):
        found, bare = errors(TABLE_4[name], seconds[name]), errors(
            TABLE_4[name], {nodes: TABLE_4[name][1] / nodes for nodes in TABLE_4[name]})
        for nodes, error in found.items():
            rows.append([name, nodes, TABLE_4[name][nodes], f"{seconds[name][nodes]:.1f}", signed(error, 2),
                         signed(closed_4(name, nodes) / TABLE_4[name][nodes] - 1, 2), signed(bare[nodes], 2)])
    return timing, seconds, faults, rows


def referred_pages(layout: ScenePages, string: PageString, items: PixelItems) -> np.ndarray:
    """N x P bool: the pages to which each node's own pixels refer.

    Parameters
    ----------
    layout, string
        P pages, and the references of each pixel.
    items
        The nodes' pixels.
    """
    owner = np.empty(len(string.distinct), dtype=np.int64)
    owner[items.pixel] = np.repeat(np.arange(len(items.own) - 1), np.diff(items.first[items.own]))
    found = np.zeros((len(items.own) - 1, len(layout)), dtype=bool)
    found[np.repeat(owner, np.diff(string.first)), string.page] = True
    return found


def _ring_rows(machine: KoanMachine, seconds, faults):
    """Rows of Rings4 by nodes: pages of other homes to which a tile refers, beside the frames for them, and faults."""
    layout, string = machine.string(4096)
    frames, rows = _frames("Rings4", machine, 4096, _CACHE), []
    for nodes, time in seconds.items():
        referred = referred_pages(layout, string, pixel_items(_SIZE, nodes))
        referred[np.arange(len(layout)) % nodes, np.arange(len(layout))] = False
        rows.append([nodes, len(layout), frames, f"{referred.sum(axis=1).mean():.0f}", f"{faults[nodes] / nodes:.0f}",
                     f"{time:.0f}", TABLE_4["Rings4"][nodes], f"{4 * seconds[4] / (nodes * time):.3f}",
                     f"{4 * TABLE_4['Rings4'][4] / (nodes * TABLE_4['Rings4'][nodes]):.3f}"])
    return rows


def _table_3(machines, base: PageTiming):
    """Rows of the table; access and faults are fitted on Teapot."""
    def times(name, timing):
        layout, _ = machines[name].string(1024)
        share = layout.size / (KOAN_SCENES[name].kilobytes << 10)
        return {nodes: machines[name].run(
            nodes=nodes, timing=timing, alone=TABLE_3[name][1], page_bytes=1024,
            frames=int(share * (_MEMORY - (KOAN_SCENES[name].kilobytes << 10) / nodes) / 1024)).time / 1e9
            for nodes in TABLE_3[name] if nodes > 1}

    least = replace(base, trap=0, serve=0)
    weights = fit(lambda timing: times("Teapot", timing), TABLE_3["Teapot"],
                  [least, replace(least, trap=1_000_000, serve=1_000_000), replace(least, access=1_000)])
    timing = replace(base, trap=int(1e6 * weights[0]), serve=int(1e6 * weights[0]), access=int(1e3 * weights[1]))
    console().note(f"table 3: trap and serve {timing.trap} ns, access {timing.access} ns")
    rows = []
    for name in TABLE_3:
        seconds = times(name, timing)
        for nodes, error in errors(TABLE_3[name], seconds).items():
            rows.append([name, nodes, TABLE_3[name][nodes], f"{seconds[nodes]:.1f}", signed(error, 2),
                         signed(closed_3(name, nodes) / TABLE_3[name][nodes] - 1, 2)])
    return timing, rows


def _cache_rows(timing: PageTiming):
    """Rows of figure 7; pages per pixel and the saturation of each scene."""
    rows, pages, saturated = [], {}, {}
    for name in KOAN_SCENES:
        machine = KoanMachine(koan_scene(name), size=_SMALL)
        pages[name] = float(machine.string(1024)[1].distinct.mean())
        found = {}
        for frames in _CACHES:
            run = machine.run(nodes=_CACHE_NODES, page_bytes=1024, frames=frames, timing=timing)
            report, found[frames] = run.report(), run.efficiency
            rows.append([name, frames, f"{run.efficiency:.3f}", f"{100 * report['miss_ratio']:.3f} %",
                         f"{report['fetched_bytes'] / 1e6:.1f}", report["traffic"]["messages"]])
        saturated[name] = saturation(found)
        console().note(f"{name}: {pages[name]:.1f} pages per pixel, saturation at pages: {_pages(saturated[name])}")
    return rows, pages, saturated


def _item_rows(machine: KoanMachine, timing: PageTiming):
    rows = []
    for schedule, side in [*(("mixed", side) for side in _SIDES), ("static", 3), ("scattered", 3)]:
        run = machine.run(nodes=32, side=side, schedule=schedule, timing=timing, alone=_ALONE["Teapot"])
        report = run.report()
        busy = report["of_a_node"]["busy_milliseconds"]
        rows.append([schedule, f"{side} x {side}", f"{run.time / 1e9:.2f}", f"{run.efficiency:.4f}",
                     f"{busy['most'] / busy['mean']:.4f}", report["faults"], report["traffic"]["ring_hops"]])
    return rows


def _pages(saturation):
    if np.isinf(saturation):
        return f"above {_CACHES[-1]}"
    return f"{saturation:.0f}" if saturation else f"below {_CACHES[0]}"


def _statements(seconds, pages, saturated, rows_4, rows_3):
    def largest(rows, name, column):
        return max(abs(float(row[column].split()[0])) for row in rows if row[0] == name)

    rows = []
    for number, found, fitted, closed in ((4, rows_4, 0.6, 0.24), (3, rows_3, 1.0, 1.0)):
        for what, column, band in (("{}: largest error", 4, fitted), ("closed form, {}", 5, closed)):
            for name in ("Teapot", "Mountain"):
                text = what.format(f"{name} (fitted)" if (name, column) == ("Teapot", 4) else name)
                value = largest(found, name, column)
                rows.append([f"table {number}, {text}", f"<= {band} %", f"{value:.2f} %",
                             grade_of(value <= band, value < 5 * band)])
    for nodes in (8, 16, 32):
        source = TABLE_4["Rings4"][4] * 4 / (TABLE_4["Rings4"][nodes] * nodes)
        ratio = seconds["Rings4"][4] * 4 / (seconds["Rings4"][nodes] * nodes)
        rows.append([f"Rings4, efficiency of {nodes} nodes over that of 4", f"{source:.3f}", f"{ratio:.3f}",
                     grade_of(1.03 <= ratio <= 1.10, ratio > 1)])
    rings, tetra = pages["Rings4"], pages["Tetra9"]
    full, less = saturated["Rings4"], saturated["Tetra9"]
    return [
        *rows,
        ["pages per pixel, Rings4", "125.91", f"{rings:.2f}", grade_of(abs(rings / 125.91 - 1) <= 0.15, True)],
        ["pages per pixel, Tetra9", "17.45", f"{tetra:.2f}", grade_of(abs(tetra / 17.45 - 1) <= 0.15, tetra < rings)],
        ["pages per pixel, Rings4 over Tetra9", "7.2 (4 to 12)", f"{rings / tetra:.1f}",
         grade_of(4 <= rings / tetra <= 12, rings > tetra)],
        ["Rings4 saturates at a cache of so many pages", "204 (102 to 408)", _pages(full),
         grade_of(102 <= full <= 408)],
        ["Rings4 needs a larger cache than Tetra9 for half the efficiency", "yes",
         f"{_pages(full)} against {_pages(less)}", grade_of(full > less)]]


@benchmark("koan")
def main() -> None:
    """Simulate tables 3 and 4 and figure 7 of the report on KOAN."""
    machines = {name: KoanMachine(koan_scene(name), size=_SIZE) for name in _ALONE}
    timing, seconds, faults, rows_4 = _table_4(machines)
    rings = _ring_rows(machines["Rings4"], seconds["Rings4"], faults["Rings4"])
    library, rows_3 = _table_3(machines, timing)
    caches, pages, saturated = _cache_rows(library)
    scenes = [[name, source.polygons, machines[name].patches if name in machines else "", source.kilobytes,
               f"{machines[name].string(1024)[0].size / 1024:.0f}" if name in machines else "",
               f"{source.rays / (1 << 18):.2f}",
               f"{len(machines[name].traced.pixel) / (1 << 18):.2f}" if name in machines else ""]
              for name, source in KOAN_SCENES.items()]
    write_report(
        "KOAN, simulated",
        f"{provenance('numpy')}; {_SIZE[0]} x {_SIZE[1]} pixels, items of 3 x 3, stand-ins for scenes; trap and serve "
        f"{timing.trap / 1e6:.1f} ms; for table 3 {library.trap / 1e6:.2f} ms and {library.access} ns a reference.",
        table(["scene", "polygons", "ours", "KB", "ours, KB", "rays per pixel", "ours, rays"], scenes),
        table(["statement", "source", "simulated", "grade"], _statements(seconds, pages, saturated, rows_4, rows_3)),
        table(["nodes", "pages of Rings4", "frames", "pages of a tile from other homes", "faults of a node",
               "seconds", "source", "efficiency over 4 nodes", "source's"], rings),
        table(["scene", "nodes", "table 4, s", "simulated, s", "error", "closed form", "t1/N alone"], rows_4),
        table(["scene", "nodes", "table 3, s", "simulated, s", "error", "closed form"], rows_3),
        table(["scene", "cache in pages of 1 KB", "efficiency", "miss ratio", "MB fetched", "messages"], caches),
        table(["schedule", "item", "seconds", "efficiency", "most busy : mean", "faults", "ring hops"],
              _item_rows(machines["Teapot"], timing)))
