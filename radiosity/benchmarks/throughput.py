"""Tests and rays per second of one cluster beside Embree on one processor core.

``radiosity bench throughput`` casts a hemisphere from each scene's ceiling on the RTL, and the same rays with
Embree, and writes out/bench/throughput.md. The RTL gives cycles; what the clock is, is an option. Hits and sums must be
golden's. Of a cluster whose area is recorded it has rays per second and LUT, too.
"""

import click
import numpy as np

from golden.cast.methods import ray_caster
from golden.cast.rays import Rays
from golden.cast.shelling import Shelling
from golden.commands.console import console
from golden.commands.parameters import ASSIGNMENTS, METHOD_CELL, PRESET, WholePair
from golden.config import PRESETS
from hw.history import last_records, read_history
from hw.simulator.simulation_config import simulation_config
from radiosity.benchmarks.casting import rate
from radiosity.benchmarks.engine import SCENES, measure, prepare_cast
from radiosity.benchmarks.job_runs import PreparedJob, job_machine
from radiosity.benchmarks.report import cell_text, output_option, provenance, write_report

__all__ = ["cluster_luts", "rays_of", "row_of"]

# The slowest of the units that `make report` places and routes, alone, on an ECP5-85 of speed grade 6.
MHZ, SOURCE = 79.6, "IntersectionUnit placed and routed alone, the slowest main unit of `make report`"
# Million tests per second in software. Source: Shen 1993.
HP720 = 0.2


def cluster_luts(preset: str, assignments: tuple[str, ...]) -> int | None:
    """The LUTs of a cluster that the history has, if it has it."""
    parameters = " ".join((*assignments, "noc.columns=1", "noc.rows=1"))
    record = last_records(read_history()).get(("ecp5", preset, parameters, "cluster", "Cluster"))
    return record and record.lut


def row_of(scene: str, found: dict, *, mhz: float, luts: int | None, embree: float, same: float) -> str:
    """A row of the table.

    Parameters
    ----------
    found
        What `radiosity.benchmarks.engine.measure` says.
    mhz
        The clock.
    luts
        Of the cluster, if known.
    embree
        Rays per second.
    same
        Share of the rays for which Embree has the machine's patch.
    """
    rays, cycles = found["rays"], found["cast_cycles"]
    tests = found["tests_per_ray"] * rays
    tests_rate, rays_rate = (mhz * count / cycles for count in (tests, rays))
    per_lut = f"{1e6 * rays_rate / luts:.0f}" if luts else ""
    return (f"| {scene} | {found['patches']} | {rays} | {tests:.0f} | {cycles} | {found['efficiency']:.3f} "
            f"| {rays / cycles:.3f} | {tests_rate:.1f} | {tests_rate / HP720:.0f} | {rays_rate:.2f} | {per_lut} "
            f"| {embree / 1e6:.2f} "
            f"| {embree / 1e6 / rays_rate:.2f} | {100 * same:.2f} |")


def rays_of(prepared: PreparedJob) -> Rays:
    """The rays of the first frustum, in the scene."""
    record, = prepared.records
    directions = record.all_directions() @ record.to_global.T
    origin = prepared.request.geometry.coordinates.points(record.origin)
    return Rays(np.broadcast_to(origin, directions.shape), directions)


@click.command()
@click.argument("scenes", nargs=-1)
@output_option("throughput")
@METHOD_CELL
@click.option("--rays", type=WholePair("AZIMUTHSxPOLARS"), default="256x64", help="Set the number of rays of the "
              "hemisphere.")
@click.option("--latency", type=click.IntRange(1), default=10, help="Set the latency of main memory in cycles.")
@click.option("--mhz", type=click.FloatRange(0, min_open=True), default=MHZ,
              help="Set the clock of the cluster in MHz.")
@click.option("--source", default=SOURCE, help="State where the clock is from.")
@click.option("--luts", type=click.IntRange(1), help="Set the LUTs of the cluster.  [default: those of "
              "docs/figures/history.csv, if it has them]")
@PRESET
@ASSIGNMENTS
def main(scenes, output, cell, rays, latency, mhz, source, luts, preset, assignments) -> None:
    """Compare one cluster with Embree on one core; SCENES default to cornell, lobby, room1627, tetra and man."""
    config = simulation_config(PRESETS[preset].with_parameters(assignments), clusters=1, topology="mesh",
                           given=tuple(one.partition("=")[0] for one in assignments), rays=rays[0] * rays[1])
    rows, luts = [], luts or cluster_luts(preset, assignments)
    with job_machine(config, latency=latency) as machine:
        for scene in scenes or SCENES:
            prepared = prepare_cast(config, scene, cell=cell, rays=rays)
            found = measure(machine, prepared)
            request = prepared.request
            hits = Shelling.of_cells(request.geometry, request.table, config).cast(request.records[0])[0]
            embree, patches = rate(ray_caster(prepared.scene, "embree").nearest_patches, rays_of(prepared))
            rows.append(row_of(scene, found, mhz=mhz, luts=luts, embree=embree,
                               same=float(np.mean(patches == hits.patch))))
            console().note(rows[-1])
    write_report(output, [
        "# Throughput of one cluster", "",
        f"{provenance('amaranth', 'embreex')}; preset {' '.join((preset, *assignments))}, {rays[0]} x "
        f"{rays[1]} rays of a hemisphere at the ceiling, {cell_text(cell)}, main memory {latency} cycles away, no "
        "subshells. Hits and sums are golden's.", "",
        f"Rates are of the simulated cycles, warm, at {mhz:g} MHz ({source}). Cycles: from the start to the last write "
        "to the ray memory; tables are read before it, hits and sums are written behind it, beside the next cast. "
        f"HP720: times the {HP720} million tests per second that the thesis has for software of its time. Embree: one "
        "processor core, the same rays in the same run, through embreex, the first patch only; best of a few runs, "
        "processor time. Same: of so many percent of the rays it has the same patch.", "",
        "| scene | patches | rays | tests | cycles | tests per cycle | rays per cycle | M tests/s | HP720 | M rays/s "
        "| rays/s per LUT | Embree M rays/s | Embree : cluster | same % |",
        "|---" * 14 + "|", *rows])
