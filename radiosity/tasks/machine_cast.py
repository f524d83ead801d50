"""One frustum on the simulated machine: its hits beside the golden model's, and its cycles by activity."""

import csv
from dataclasses import dataclass, field
from pathlib import Path
from typing import cast

import numpy as np

from golden.base.output import whole_file
from golden.base.plural import counted
from golden.base.progress_bar import progress_bar
from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord
from golden.engine.jobs.phase_request import phase_request
from golden.engine.jobs.result_formats import HitFormat, exceeding
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.cell_choice import choose_cell
from golden.engine.schedule.job_shelling import job_shelling
from radiosity.charts.chart import Line, line_figure, write_figure
from radiosity.flow.simulator.cast_report import cast_report
from radiosity.flow.simulator.job_result import JobResult
from radiosity.flow.simulator.simulated_machine import SimulatedMachine, WaveformWindow
from radiosity.flow.simulator.simulation_config import overridden_text
from radiosity.flow.simulator.utilization import utilization

__all__ = ["CastOptions", "MachineCast", "MachineCastResult", "WaveformWindow", "write_counters", "write_timeline"]


@dataclass(frozen=True, kw_only=True)
class CastOptions:
    """How a frustum is cast, and what is recorded.

    Parameters
    ----------
    cell
        Cell size as a share of the scene's longest side; None: `golden.engine.schedule.cell_choice` chooses it.
    ratio
        Rays of the frustum for each ray cast to schedule it.
    casts
        How many times it is cast, each time as a job; the first one loads the tables.
    waves, timeline, counters
        The signals of the last cast (.vcd), its utilization (.svg), and the counters of all casts (.csv).
    changes
        What the simulation has overridden, see `radiosity.flow.simulator.simulation_config.overridden`.
    """

    cell: float | None = None
    ratio: int = 64
    casts: int = 3
    waves: WaveformWindow | None = None
    timeline: Path | None = None
    counters: Path | None = None
    changes: dict = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class MachineCastResult:
    """The machine's hits and what they took.

    Parameters
    ----------
    hits
        Of the last cast.
    report, text
        Counts ready for JSON, and as lines.
    agrees
        Whether hits and sums equal the golden model's.
    columns, rows
        The frustum's grid of rays; ray c + r * columns is in column c of row r.
    cycles
        Int64 of each cast: from the first section's beginning to the last one's end.
    counters
        By name int64, casts x clusters: the events that each cluster has counted, and its own ``cycles``.
    """

    hits: FixedHits
    report: dict
    text: str
    agrees: bool
    columns: int
    rows: int
    cycles: np.ndarray
    counters: dict[str, np.ndarray]

    def __repr__(self) -> str:
        clusters = counted(self.report["clusters"], "cluster")
        return (f"<MachineCastResult: {self.columns} x {self.rows} rays, {clusters}, "
                f"{self.cycles[-1]} cycles, {'' if self.agrees else 'not '}the golden model's hits>")

    @property
    def patch(self) -> np.ndarray:
        """Rows x columns int64: the patch that each ray hits, or -1."""
        return self.hits.patch.reshape(self.rows, self.columns)


class MachineCast:
    """A frustum that is scheduled, and cast by the golden model, before a machine casts it.

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
        # Of the whole frustum, which may be larger than a cluster's ray memory.
        whole = config.for_rays(len(record))
        shelling = job_shelling(geometry, whole, cell=self._cell)
        self._request = phase_request(
            [record], geometry, shelling.table, config, ratio=options.ratio, clusters=config.noc.clusters,
            weights=weights, hit_format=_hit_format(config), sums=weights is not None)
        self._expected = shelling.cast(record)[0]

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
        options = self._options
        samples: list = []
        done: list[JobResult] = []
        for number in progress_bar(range(options.casts), desc="cast", unit="cast", delay=2, disable=not progress):
            is_last = number == options.casts - 1
            done.append(machine.run([self._request], timeline=samples if options.timeline and is_last else None,
                                    waves=options.waves if is_last else None))
        if options.counters:
            write_counters(options.counters, done)
        if options.timeline:
            write_timeline(options.timeline, samples, self._config,
                           title=f"{title}, {counted(self._config.noc.clusters, 'cluster')}")
        hits = cast("FixedHits", done[-1].frusta[0][0].hits)  # the phase requests whole hits
        report = self._report(done, hits)
        return MachineCastResult(hits=hits, report=report, text=_text(report),
                                 agrees=not report["differences"] and not report["sums"],
                                 columns=self._record.columns, rows=len(self._record) // self._record.columns,
                                 cycles=np.array([one.cycles.cast for one in done], dtype=np.int64),
                                 counters={name: np.array([[cluster[name] for cluster in one.counters]
                                                           for one in done], dtype=np.int64)
                                           for name in done[0].counters[0]})

    def _report(self, done: list[JobResult], hits: FixedHits) -> dict:
        ((last,),), network = done[-1].frusta, self._config.noc
        return {"patches": len(self._geometry), "clusters": network.nodes, "topology": network.topology,
                "cell": self._cell, "is_cell_chosen": self._options.cell is None,
                "overridden": self._options.changes,
                **cast_report(self._record, done, self._config),
                "differences": len(hits.differences(self._expected)),
                "sums": 0 if last.sums is None else int((last.sums != self._expected_sums()).sum())}

    def _expected_sums(self):
        """N int64: of each patch the weights of the rays that hit it."""
        patch, sums = self._expected.patch, np.zeros(len(self._geometry), dtype=np.int64)
        met = np.flatnonzero(patch >= 0)
        np.add.at(sums, patch[met], self._request.weights[met // self._record.columns])
        return sums


def _hit_format(config):
    """Records of 8 bytes if they hold the machine's numbers, else of 16."""
    return HitFormat.FULL if exceeding(config, HitFormat.COMPACT, sums=False) else HitFormat.COMPACT


def write_counters(path: Path, done: list[JobResult]) -> None:
    """Write a table with a row for each cluster of each cast.

    Its columns are cast, cluster, cast_cycles (of all clusters, from the first cast's beginning to the last one's end)
    and the names of the counters, which begin with the cluster's own cycles.
    """
    with whole_file(path) as part, part.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["cast", "cluster", "cast_cycles", *done[0].counters[0]])
        for number, one in enumerate(done):
            for cluster, counters in enumerate(one.counters):
                rows.writerow([number, cluster, one.cycles.cast, *counters.values()])


def write_timeline(path: Path, samples: list, config: Config, *, title: str) -> None:
    """Write a chart of the utilization of each unit; samples are those of `radiosity.flow.simulator.utilization`."""
    at, busy = utilization(samples, config)
    write_figure(path, line_figure([Line(name=name, x=at, y=values) for name, values in busy.items()], title=title,
                                   x_name="cycle", y_name="share of cycles", y_top=1.0))


def _text(report: dict) -> str:
    bound, sources = report["bound"], report["sources"]
    lines = [
        f"machine: {counted(report['clusters'], 'cluster')}, {report['topology']}, "
        f"{counted(report['patches'], 'patch')}, cell {report['cell']:g}"
        + " (chosen)" * report["is_cell_chosen"] + overridden_text(report["overridden"]),
        f"differences from golden: {counted(report['differences'], 'hit')}, {counted(report['sums'], 'sum')}",
        f"cycles {report['cycles']}: cast {report['cast_cycles']}, results {report['result_cycles']} after it; the "
        f"first time {report['first_cycles']}, of which tables {report['load_cycles']}",
        "lower bound  " + ", ".join(f"{name} {cycles}" for name, cycles in bound.items())
        + f": {report['of_bound']:.2f} of the cast's cycles",
        f"pipeline efficiency {report['efficiency']:.3f}, tests per ray {report['tests_per_ray']:.2f}, "
        f"tests per patch (EDRC) {report['edrc']:.1f}",
        f"patches: own {sources['own']}, store {sources['kept']}, remote {sources['remote']}, cache "
        f"{sources['hits']}, main memory {sources['misses']}",
        f"deferred requests {report['deferred']}; {counted(report['shared']['flits'], 'flit')}, {report['links']:.2f} "
        "links each",
        "", f"{'cluster':28} " + " ".join(f"{number:>9}" for number in range(report["clusters"]))]
    for name in report["each"][0]:
        values = [one[name] for one in report["each"]]
        lines.append(f"{name.replace('_', ' '):28} " + " ".join(
            f"{value:9.3f}" if isinstance(value, float) else f"{value:9}" for value in values))
    return "\n".join(lines)
