"""Latency against offered load, beside the figures of BookSim 2.

``radiosity bench network_load`` runs the cycle-accurate model of the network, which the hardware equals cycle by
cycle, with 4 x 4 and 8 x 8 nodes: meshes of 1, 2 and 4 virtual channels, tori of 2 and 4. It writes
out/bench/network_load.md and a chart for each size, pattern and length of packets.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from benchmarks.report import benchmark, provenance, table, write_chart, write_report
from benchmarks.traffic import SATURATED, Measurement, Window, bound, measure, pattern
from golden.engine.noc.delay import zero_load_latency
from golden.engine.noc.routing import route
from golden.engine.noc.topology import Topology
from radiosity.charts.chart import Line
from radiosity.cli.console import console

SIDES = (4, 8)
NETWORKS = (("mesh", 1), ("mesh", 2), ("mesh", 4), ("torus", 2), ("torus", 4))
TRAFFIC = ("uniform", "transpose", "hotspot")
LENGTHS = (1, 4, 5)
BUFFER_FLITS, SEED = 8, 1
LOW = 0.01
# Runs at low load, where packets are few.
LOW_RUNS = 4
WINDOW = Window(warm_up=2000, measured=4000, drain=1500)
# Loads of the first look, as shares of the bound, and how many of the second one, between two of them.
COARSE = np.linspace(0.4, 1, 10)
FINE = 9

# BookSim 2, commit 28f43299: mesh, dimension order, 8-flit buffers, two-stage routers with speculative switch
# allocation (routing_delay 0, vc_alloc_delay 1, sw_alloc_delay 1, st_final_delay 1, speculative 1), one-cycle links,
# sample period 2000, 3 periods of warm-up. By side, flits, pattern and channels: latency at low load, saturation (the
# largest load with less than 3 x that), flits accepted at an offered 1.0.
BOOKSIM = {
    (4, 1, "uniform"): {1: (12.5, 0.660, 0.681), 2: (12.5, 0.749, 0.768), 4: (12.5, 0.768, 0.775)},
    (4, 1, "transpose"): {1: (12.4, 0.331, 0.625), 2: (12.4, 0.331, 0.625), 4: (12.4, 0.327, 0.625)},
    (4, 1, "hotspot"): {1: (12.4, 0.362, 0.396), 2: (12.4, 0.381, 0.398), 4: (12.4, 0.381, 0.393)},
    (4, 4, "uniform"): {1: (15.4, 0.551, 0.582), 2: (15.4, 0.675, 0.725), 4: (15.4, 0.702, 0.748)},
    (4, 4, "transpose"): {1: (15.4, 0.319, 0.623), 2: (15.4, 0.327, 0.622), 4: (15.4, 0.319, 0.623)},
    (4, 4, "hotspot"): {1: (15.0, 0.346, 0.390), 2: (15.1, 0.370, 0.396), 4: (15.1, 0.377, 0.390)},
    (8, 1, "uniform"): {1: (20.9, 0.366, 0.369), 2: (20.9, 0.412, 0.407), 4: (20.9, 0.424, 0.404)},
    (8, 1, "transpose"): {1: (20.9, 0.141, 0.344), 2: (20.9, 0.141, 0.344), 4: (20.9, 0.141, 0.344)},
    (8, 1, "hotspot"): {1: (20.2, 0.126, 0.136), 2: (20.2, 0.130, 0.136), 4: (20.2, 0.130, 0.133)},
    (8, 4, "uniform"): {1: (24.1, 0.300, 0.315), 2: (24.2, 0.377, 0.388), 4: (24.2, 0.397, 0.405)},
    (8, 4, "transpose"): {1: (23.7, 0.141, 0.342), 2: (23.7, 0.138, 0.342), 4: (23.7, 0.141, 0.343)},
    (8, 4, "hotspot"): {1: (23.5, 0.122, 0.134), 2: (23.5, 0.130, 0.136), 4: (23.5, 0.130, 0.134)},
}
# Mean latency at loads, uniform traffic, by side, flits and channels; None where it is saturated.
BOOKSIM_CURVES = {
    (4, 1, 1): {0.1: 12.6, 0.2: 12.7, 0.3: 13.0, 0.4: 13.3, 0.5: 13.8, 0.6: 15.7, 0.7: None},
    (4, 1, 2): {0.1: 12.7, 0.2: 12.8, 0.3: 13.1, 0.4: 13.6, 0.5: 14.2, 0.6: 15.6, 0.7: 19.3},
    (4, 4, 1): {0.1: 16.1, 0.2: 16.6, 0.3: 17.9, 0.4: 20.0, 0.5: 25.0, 0.6: None},
    (4, 4, 2): {0.1: 16.3, 0.2: 17.0, 0.3: 18.5, 0.4: 20.4, 0.5: 23.0, 0.6: 28.2, 0.7: 70.9},
    (8, 1, 1): {0.05: 20.9, 0.1: 21.0, 0.2: 21.5, 0.3: 23.1, 0.35: 26.2, 0.4: None},
    (8, 1, 2): {0.05: 20.9, 0.1: 21.1, 0.2: 21.9, 0.3: 23.8, 0.35: 25.8, 0.4: 32.5},
    (8, 4, 1): {0.05: 24.2, 0.1: 25.0, 0.2: 27.6, 0.3: 53.9, 0.35: None},
    (8, 4, 2): {0.05: 24.4, 0.1: 25.5, 0.2: 28.3, 0.3: 34.3, 0.35: 41.6, 0.4: None},
}


@dataclass(frozen=True, kw_only=True)
class Case:
    """One network with one kind of traffic."""

    side: int
    topology: str
    channels: int
    traffic: str
    length: int

    def __str__(self) -> str:
        return f"{self.side} x {self.side} {self.topology}, {self.channels} VC"


@dataclass(frozen=True, kw_only=True)
class Curve:
    """Measurements by ascending load, and the load that no network can go beyond."""

    loads: np.ndarray
    found: list[Measurement]
    bound: float

    @property
    def latency(self) -> np.ndarray:
        """Mean latencies."""
        return np.array([one.latency for one in self.found])

    @property
    def low(self) -> float:
        """Mean latency at low load."""
        return float(np.mean(self.latency[self.loads == LOW]))

    @property
    def saturation(self) -> float:
        """The largest load up to which no measured one saturated the network."""
        within = self.latency < SATURATED * self.low
        return float(self.loads[np.argmin(within) - 1] if not within.all() else self.loads[-1])


def run(case: Case) -> Curve:
    """Loads far apart first, then near the point where latency rises."""
    topology = Topology(case.topology, case.side, case.side)
    routing, probabilities = route(topology, case.channels), pattern(case.traffic, topology)
    most = bound(routing, probabilities)

    def look(loads, seed):
        return measure(routing, probabilities, loads=loads, length=case.length, buffer_flits=BUFFER_FLITS,
                       window=WINDOW, seed=seed)

    known = BOOKSIM_CURVES.get((case.side, case.length, case.channels), {})
    known = list(known) if (case.topology, case.traffic) == ("mesh", "uniform") else []
    loads = np.unique(np.round([*(most * COARSE[0] * np.array([0.25, 0.5, 0.75])), *known, *(most * COARSE), 1], 5))
    loads = np.concatenate([[LOW] * LOW_RUNS, loads])
    curve = Curve(loads=loads, found=look(loads, SEED), bound=most)
    last = int(np.searchsorted(loads, curve.saturation))
    between = np.linspace(loads[last], loads[min(last + 1, len(loads) - 1)], FINE + 2)[1:-1]
    loads = np.concatenate([loads, between])
    found = [*curve.found, *look(between, SEED + 100)]
    order = np.argsort(loads, kind="stable")
    return Curve(loads=loads[order], found=[found[number] for number in order], bound=most)


def overloads(curves: dict[Case, Curve]) -> list[list]:
    """Rows of latency, saturation and what is accepted, beside BookSim's."""
    rows = []
    for case, curve in curves.items():
        theirs = BOOKSIM.get((case.side, case.length, case.traffic), {}).get(case.channels)
        theirs = theirs if case.topology == "mesh" else None
        low, saturation, accepted, ratio = (
            f"{theirs[0]:.1f}", f"{theirs[1]:.3f}", f"{theirs[2]:.3f}", f"{curve.saturation / theirs[1]:.2f}",
        ) if theirs else [""] * 4
        rows.append([case, case.traffic, case.length, f"{curve.low:.1f}", low, f"{curve.saturation:.3f}", saturation,
                     ratio, f"{curve.bound:.3f}", f"{curve.found[-1].accepted:.3f}", accepted])
    return rows


def saturations(curves: dict[Case, Curve]) -> list[list]:
    """The same loads with the networks side by side."""
    rows = []
    for side, traffic, length in _kinds(curves):
        theirs, cells = BOOKSIM.get((side, length, traffic), {}), []
        for topology, channels in NETWORKS:
            case = Case(side=side, topology=topology, channels=channels, traffic=traffic, length=length)
            known = theirs.get(channels) if topology == "mesh" else None
            curve = curves.get(case)
            if not cells:
                cells.append(f"{curve.low:.1f}" + (f" ({known[0]:.1f})" if known else ""))
            cells.append(f"{curve.saturation:.3f}" + (f" ({known[1]:.3f})" if known else "") if curve else "")
        rows.append([f"{side} x {side}, {traffic}, {length}", *cells])
    return rows


def _kinds(curves):
    return dict.fromkeys((case.side, case.traffic, case.length) for case in curves)


def latencies(curves: dict[Case, Curve]) -> list[list]:
    """Mean latency at the loads that BookSim was run with."""
    rows = []
    for case, curve in curves.items():
        known = BOOKSIM_CURVES.get((case.side, case.length, case.channels))
        if known is None or (case.topology, case.traffic) != ("mesh", "uniform"):
            continue
        cells = []
        for load, theirs in known.items():
            ours = curve.latency[np.argmin(abs(curve.loads - load))]
            limit = SATURATED * curve.low
            cells.append(f"{load}: {f'{ours:.1f}' if ours < limit else 'saturated'} ({theirs or 'saturated'})")
        rows.append([case, case.length, " · ".join(cells)])
    return rows


def charts(curves: dict[Case, Curve]) -> list[str]:
    """Write a chart for each size, pattern and length: lines that show them."""
    lines = []
    for side, traffic, length in _kinds(curves):
        chosen = {case: curve for case, curve in curves.items()
                  if (case.side, case.traffic, case.length) == (side, traffic, length)}
        end = max(curve.saturation for curve in chosen.values()) * 1.1
        top = 4 * max(curve.low for curve in chosen.values())
        drawn = []
        for case, curve in chosen.items():
            # The line ends where it leaves the chart.
            shown = int(np.argmax(curve.latency > top)) + 1 if (curve.latency > top).any() else len(curve.loads)
            shown = min(shown, max(1, int((curve.loads <= end).sum())))
            drawn.append(Line(name=f"{case.topology}, {case.channels} VC", x=curve.loads[:shown],
                              y=curve.latency[:shown], ends_at=curve.saturation))
        name = f"network_load_{side}x{side}_{traffic}_{length}"
        write_chart(name, drawn, title=f"{side} x {side}, {traffic}, {length}-flit packets",
                    x_name="offered flits per node and cycle", y_name="mean latency, cycles", y_top=top)
        lines.append(f"![{side} x {side}, {traffic}, {length} flits]({name}.svg)")
    return lines


@benchmark("network_load")
def main() -> None:
    """Measure the network's latency against the offered load, beside BookSim 2."""
    curves = {}
    for side, traffic, length, (topology, channels) in product(SIDES, TRAFFIC, LENGTHS, NETWORKS):
        if length != 4 or topology == "mesh":
            case = Case(side=side, topology=topology, channels=channels, traffic=traffic, length=length)
            curve = curves[case] = run(case)
            console().note(f"{case}, {traffic}, {length} flits: {curve.low:.1f} cycles, saturated from "
                           f"{curve.saturation:.3f}")
    law = ", ".join(f"{zero_load_latency(Topology(name, side, side).hops.mean()):.2f} in a {side} x {side} {name}"
                    for side in SIDES for name in ("mesh", "torus"))
    write_report(
        "Latency against load",
        f"Queues of {BUFFER_FLITS} flits, routers of 2 cycles, links of 1. {WINDOW.warm_up} cycles of warm-up, "
        f"{WINDOW.measured} measured, {WINDOW.drain} of drain; latency with the time in the source's queue; saturation "
        f"is the largest load with less than {SATURATED} x the latency at {LOW} "
        "(`benchmarks/traffic.py`). BookSim 2 counts one cycle more at the node. "
        "The delay law gives, for one flit and uniform traffic, "
        f"{law}. Seed {SEED}. {provenance('numpy')}.",
        "## Low load, saturation, overload",
        table(["network", "traffic", "flits", "latency at low load", "BookSim's latency", "saturation",
               "BookSim's saturation", "ratio", "bound", "accepted at 1.0", "BookSim's accepted"], overloads(curves)),
        "## Saturation by network",
        "In brackets BookSim's figures. Low load: of the mesh with one channel.",
        table(["nodes, traffic, flits of a packet", "low load",
               *(f"{topology}, {channels} VC" for topology, channels in NETWORKS)], saturations(curves)),
        "## Latency against load, uniform traffic (BookSim's in brackets)",
        table(["network", "flits", "load: latency"], latencies(curves)),
        "## Charts", "Triangles mark saturation.", *charts(curves))
