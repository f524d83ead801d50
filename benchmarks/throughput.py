"""Tests and rays per cycle of one cluster, and per second of a routed machine, beside Embree on this computer.

``radiosity bench throughput`` casts a hemisphere from each scene's ceiling on the RTL, and the same rays with
Embree, and writes out/bench/throughput.md. Hits and sums must be golden's. The RTL gives cycles. Seconds follow from
the clock of a whole machine of the same parameters that docs/figures/history.csv has as placed and routed, or from
``--mhz``; without either there are none. LUTs are those of that machine, or of the recorded cluster.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from statistics import median

import click
import numpy as np
from click.core import ParameterSource

from benchmarks.bare_embree import LANES, BareEmbree
from benchmarks.casting import REPEATS, binding, rate, shortest
from benchmarks.engine import LATENCY, RAYS, SCENES, machine_config, measure, prepare_cast
from benchmarks.report import benchmark, cell_text, provenance, table, write_report
from golden.base.errors import InputError
from golden.base.processors import processors
from golden.base.spread import in_threads, spans
from golden.cast.rays import Rays
from golden.engine.cast.shelling import Shelling
from radiosity.cli.console import console
from radiosity.cli.parameters import ASSIGNMENTS, METHOD_CELL, PRESET, FiniteRange
from radiosity.flow.synthesis.history import MACHINE, Record, last_records, machine_parameters, read_history
from radiosity.machines.engine.job_runs import PreparedJob, job_machine

__all__ = ["EmbreeRates", "clock_text", "embree_rates", "rays_of", "recorded", "row_of"]

# Rays of a thread at least.
_LEAST = 1024


@dataclass(frozen=True, kw_only=True)
class EmbreeRates:
    """Rays per second of Embree.

    Parameters
    ----------
    one, all
        By its own interface: on one core, in processor time, and on all, in real time.
    binding
        By embreex on one core.
    same
        Share of the rays for which its own interface has the machine's patch.
    """

    one: float
    all: float
    binding: float
    same: float


def recorded(preset: str, assignments: tuple[str, ...]) -> Iterator[Record]:
    """The last records that the history has of these parameters with one cluster: of a whole machine, of a cluster."""
    parameters, last = machine_parameters(preset, assignments), last_records(read_history())
    for block, unit in MACHINE, ("engine", "Engine"), ("cluster", "Cluster"):
        if record := last.get(("ecp5", preset, parameters, block, unit)):
            yield record


def clock_text(record: Record) -> str:
    """What a clock is of: the median of a machine's routes."""
    return ("of the whole machine, placed and routed on an ECP5-85 of speed grade 6, "
            f"{record.routes}, commit {record.commit}")


def row_of(scene: str, found: dict, *, mhz: float | None, luts: int | None, embree: EmbreeRates) -> list[str]:
    """A row of the table.

    Parameters
    ----------
    found
        What `benchmarks.engine.measure` says.
    mhz, luts
        The clock, and the LUTs, if known.
    embree
        Of the same rays.
    """
    rays, cycles = found["rays"], found["cast_cycles"]
    tests = found["tests_per_ray"] * rays
    per_lut = f"{1e6 * rays / cycles / luts:.1f}" if luts else ""
    rates = ["", ""]
    if mhz:
        rates = [f"{mhz * rays / cycles:.2f}", f"{1e6 * mhz * rays / cycles / luts:.0f}" if luts else ""]
    return [f"`{scene}`", str(found["patches"]), str(rays), f"{tests:.0f}", str(cycles), f"{found['efficiency']:.3f}",
            f"{rays / cycles:.3f}", per_lut, *rates, *(f"{one / 1e6:.2f}" for one in (
                embree.one, embree.all, embree.binding)), f"{100 * embree.same:.2f}"]


def embree_rates(prepared: PreparedJob, patches: np.ndarray) -> EmbreeRates:
    """Embree's rates for the rays of the first frustum.

    Parameters
    ----------
    prepared, patches
        The job, and the patches that its rays meet.
    """
    rays, bare = rays_of(prepared), BareEmbree(prepared.scene)
    origin, direction = bare.prepared(rays)
    one, met = rate(lambda _: bare.cast(origin, direction, any_hit=False), rays)
    spread, parts = in_threads(processors()), spans(len(origin), _LEAST)
    best, _ = shortest(lambda: list(spread(
        lambda first, end: bare.cast(origin[first:end], direction[first:end], any_hit=False), parts)),
        time.perf_counter)
    return EmbreeRates(one=one * len(origin) / len(rays), all=len(origin) / best,
                       binding=rate(binding(prepared.scene), rays)[0], same=float(np.mean(met == patches[:len(met)])))


def rays_of(prepared: PreparedJob) -> Rays:
    """The rays of the first frustum, in the scene."""
    record, = prepared.records
    directions = record.all_directions() @ record.to_global.T
    origin = prepared.request.geometry.coordinates.points(record.origin)
    return Rays(np.broadcast_to(origin, directions.shape), directions)


@benchmark("throughput", SCENES)
@METHOD_CELL
@RAYS
@click.option("--mhz", type=FiniteRange(0, min_open=True), help="Set the clock of the machine in MHz.  [default: "
              "that of docs/figures/history.csv, if it has the whole machine]")
@click.option("--source", default="given", show_default=True, help="With --mhz, state what it is the clock of.")
@PRESET
@ASSIGNMENTS
def main(scenes, cell, rays, mhz, source, preset, assignments) -> None:
    """Compare one cluster with Embree; SCENES default to cornell, lobby, room1627, tetra and man."""
    if mhz is None and click.get_current_context().get_parameter_source("source") is ParameterSource.COMMANDLINE:
        raise InputError("--source needs --mhz")
    config = machine_config(preset, assignments, rays)
    rows, known = [], list(recorded(preset, assignments))
    luts = known[0].lut if known else None
    if mhz is None and known and known[0].block != "cluster" and known[0].mhz:
        mhz, source = median(known[0].mhz), clock_text(known[0])
    with job_machine(config, latency=LATENCY) as machine:
        for scene in scenes:
            prepared = prepare_cast(config, scene, cell=cell, rays=rays)
            found = measure(machine, prepared)
            request = prepared.request
            hits = Shelling.of_cells(request.geometry, request.table, config).cast(request.records[0])[0]
            rows.append(row_of(scene, found, mhz=mhz, luts=luts, embree=embree_rates(prepared, hits.patch)))
            console().note(" ".join(rows[-1]))
    clock = f"at {mhz:g} MHz ({source})" if mhz else "not known: no machine of these parameters is recorded as routed"
    write_report(
        "Throughput of one cluster",
        f"{provenance('amaranth', 'embreex')}; preset {' '.join((preset, *assignments))}, {rays[0]} x "
        f"{rays[1]} rays of a hemisphere at the ceiling, {cell_text(cell)}, main memory {LATENCY} cycles away, no "
        "subshells. Hits and sums are golden's.",
        "Cycles: from the start to the last write to the ray memory, warm; tables are read before it, hits and sums "
        f"are written behind it, beside the next cast. Rays per second: {clock}. LUTs: {luts or 'not known'}. Embree: "
        f"the same rays in the same run, the first patch only; its own interface, {LANES} rays in a call, on one core "
        f"in processor time and on all {processors()} in real time; the binding embreex on one core; best of {REPEATS} "
        "runs or more. Same: of so many percent of the rays it has the same patch. Watts of neither are known.",
        table(["scene", "patches", "rays", "tests", "cycles", "tests per cycle", "rays per cycle",
               "rays per cycle and 10^6 LUT", "M rays/s", "rays/s per LUT", "Embree M rays/s, one core", "all cores",
               "binding", "same %"], rows))
