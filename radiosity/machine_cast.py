"""One frustum on the simulated machine: its hits beside golden's, and where its cycles went."""

import csv
from dataclasses import dataclass, field
from pathlib import Path

from golden.cast.fixed_hits import FixedHits
from golden.cast.shelling import Shelling
from golden.config import Config
from golden.frustum import FrustumRecord
from golden.memory_map import machine_image
from golden.output import whole_file
from golden.plural import counted
from golden.progress_bar import progress_bar
from golden.scene.patch_geometry import PatchGeometry
from golden.schedule.cell_choice import choose_cell
from golden.schedule.phase import machine_schedule
from hw.simulator.cast_report import cast_report
from hw.simulator.cast_result import CastResult
from hw.simulator.simulated_machine import SimulatedMachine, WaveformWindow
from hw.simulator.simulation_config import overridden_text
from radiosity.timeline import write_timeline

__all__ = ["CastOptions", "MachineCast", "MachineCastResult", "WaveformWindow", "write_counters"]


@dataclass(frozen=True, kw_only=True)
class CastOptions:
    """How a frustum is cast, and what is recorded.

    Parameters
    ----------
    cell
        Cell size as a share of the scene's longest side; None: `golden.schedule.cell_choice` chooses it.
    ratio
        Rays of the frustum for each ray cast to schedule it.
    casts
        How many times it is cast.
    waves, timeline, counters
        The signals of the last cast (.vcd), its utilization (.svg), and the counters of all casts (.csv).
    changes
        What the simulation has overridden, see `hw.simulator.simulation_config.overridden`.
    """

    cell: float | None = None
    ratio: int = 64
    casts: int = 3
    waves: WaveformWindow | None = None
    timeline: Path | None = None
    counters: Path | None = None
    changes: dict = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True, eq=False)
class MachineCastResult:
    """The machine's hits and what they took.

    Parameters
    ----------
    hits
        Of the last cast.
    report, text
        Counts ready for JSON, and as lines.
    agrees
        Whether hits and sums are golden's.
    """

    hits: FixedHits
    report: dict
    text: str
    agrees: bool


class MachineCast:
    """A frustum that is scheduled, and cast by golden, before a machine casts it.

    Parameters
    ----------
    record, geometry, weights
        The frustum, the patches in its coordinates, and the weights of a hemisphere's rows; None of a screen.
    config
        The machine's configuration.
    options
        How it is cast.

    Raises
    ------
    InputError
        The machine is too small for the frustum.
    """

    def __init__(self, record: FrustumRecord, geometry: PatchGeometry, weights, config: Config, options: CastOptions):
        self._record, self._geometry, self._config, self._options = record, geometry, config, options
        self._cell = choose_cell([record], geometry, config).cell if options.cell is None else options.cell
        shelling = Shelling(geometry, config, cell=self._cell)
        plan = machine_schedule(record, geometry, shelling.table, config, ratio=options.ratio)
        self._image = machine_image(record, geometry, shelling.table, config, plan, weights=weights)
        self._expected = self._image.with_results(shelling.cast(record)[0])
        self._total = 0 if weights is None else int(weights.sum()) * record.columns

    def run(self, machine: SimulatedMachine, *, title: str, progress: bool = False) -> MachineCastResult:
        """Cast the frustum and write what the options name.

        Parameters
        ----------
        machine
            The machine; ``traced`` if there are waves.
        title
            The title of the timeline.
        progress
            Show a bar once two seconds have passed.
        """
        options, samples, done = self._options, [], []
        for number in progress_bar(range(options.casts), desc="cast", unit="cast", delay=2, disable=not progress):
            is_last = number == options.casts - 1
            done.append(machine.cast(
                self._image, total=self._total, sums=True, again=number > 0,
                timeline=samples if options.timeline and is_last else None, waves=options.waves if is_last else None))
        if options.counters:
            write_counters(options.counters, done)
        if options.timeline:
            write_timeline(options.timeline, samples, self._config,
                           title=f"{title}, {counted(self._config.noc.nodes, 'cluster')}")
        report = self._report(done)
        return MachineCastResult(hits=done[-1].image.hits(), report=report, text=_text(report),
                                 agrees=not report["differences"] and not report["sums"])

    def _report(self, done: list[CastResult]) -> dict:
        last, network = done[-1].image, self._config.noc
        return {"patches": len(self._geometry), "clusters": network.nodes, "topology": network.topology,
                "cell": self._cell, "is_cell_chosen": self._options.cell is None,
                "overridden": self._options.changes,
                **cast_report(self._record, done, self._config),
                "differences": len(last.hits().differences(self._expected.hits())),
                "sums": int((last["sums"] != self._expected["sums"]).sum())}


def write_counters(path: Path, done: list[CastResult]) -> None:
    """Write a table with a row for each cluster of each cast.

    Its columns are cast, cluster, cast_cycles (of the whole cast) and the names of the counters, which begin with the
    cluster's own cycles.
    """
    with whole_file(path) as part, part.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["cast", "cluster", "cast_cycles", *done[0].counters[0]])
        for number, one in enumerate(done):
            for cluster, counters in enumerate(one.counters):
                rows.writerow([number, cluster, one.cycles, *counters.values()])


def _text(report: dict) -> str:
    bound, sources = report["bound"], report["sources"]
    lines = [
        f"machine: {counted(report['clusters'], 'cluster')}, {report['topology']}, "
        f"{counted(report['patches'], 'patch')}, cell {report['cell']:g}"
        + " (chosen)" * report["is_cell_chosen"] + overridden_text(report["overridden"]),
        f"differences from golden: {counted(report['differences'], 'hit')}, {counted(report['sums'], 'sum')}",
        f"cycles {report['cycles']} (the first time {report['first_cycles']}), tables {report['load_cycles']}, "
        f"results {report['result_cycles']}",
        "lower bound  " + ", ".join(f"{name} {cycles}" for name, cycles in bound.items())
        + f": {report['of_bound']:.2f} of the cycles",
        f"pipeline efficiency {report['efficiency']:.3f}, tests per ray {report['tests_per_ray']:.2f}, "
        f"tests per patch (EDRC) {report['edrc']:.1f}",
        f"patches: own {sources['own']}, remote {sources['remote']}, cache {sources['hits']}, main memory "
        f"{sources['misses']}; {report['links']:.2f} links per flit",
        "", f"{'cluster':28} " + " ".join(f"{number:>9}" for number in range(report["clusters"]))]
    for name in report["each"][0]:
        values = [one[name] for one in report["each"]]
        lines.append(f"{name.replace('_', ' '):28} " + " ".join(
            f"{value:9.3f}" if isinstance(value, float) else f"{value:9}" for value in values))
    return "\n".join(lines)
