"""What the host prepares for a phase, and how well it fits."""

from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.base.output import whole_file
from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.shelling import Shelling
from golden.engine.config import Config
from golden.engine.frustum import hemisphere_record
from golden.engine.memory_map import phase_image
from golden.engine.noc.topology import Topology
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.assignment import mean_hops, traffic
from golden.engine.schedule.ceiling_points import ceiling_points
from golden.engine.schedule.phase import Schedule, schedule
from golden.engine.schedule.usage import cumulative_frequency, effectiveness
from golden.light.image import label_colours, write_png
from golden.scene.open import open_scene

__all__ = ["schedule_phase"]

# Of the sixteen points on the ceiling, numbered from 1: the first is the reference, and these are served too.
SERVED = (4, 7, 10, 13)
PICTURE_WIDTH = 1024


def schedule_phase(scene: str, config: Config, *, rays: tuple[int, int], cell: float, origin=None, normal=None,
                   clusters: int = 8, ratio: int = 64, ray_capacity: int | None = None, capacity: int | None = None,
                   topology: str | None = None, output: Path | None = None,
                   picture: Path | None = None) -> tuple[dict, str]:
    """Schedule a phase of castings from a sparse casting, and cast to see how well it fits.

    Parameters
    ----------
    scene
        A name as `open_scene` takes it.
    config
        The machine's configuration.
    rays, cell
        Azimuths and polars of a hemisphere, and cell size as a share of the scene's longest side.
    origin, normal
        The reference point and the middle of its hemisphere. Default: the first of `ceiling_points`.
    clusters, ratio, ray_capacity, capacity, topology
        See `golden.engine.schedule.phase.schedule`.
    output, picture
        Files for a memory image (.bin) and for a picture of the sections (.png).

    Returns
    -------
    The report for JSON, and as lines.

    Raises
    ------
    InputError
        The scene or a parameter cannot be used.
    """
    opened, hemisphere = open_scene(scene), Hemisphere(*rays)
    if (origin is None) != (normal is None):
        raise InputError("schedule: --origin and --normal must be given together")
    points, served = np.array([origin]), ()
    if origin is None:
        (points, normal), served = ceiling_points(opened), SERVED
    geometry = PatchGeometry.of(opened, config.numbers, points)
    shelling = Shelling(geometry, config, cell=cell)
    records = {number: hemisphere_record(hemisphere, geometry.coordinates, points[number - 1], normal)
               for number in (1, *served)}
    plan = schedule(records[1], geometry, shelling.table, config, clusters=clusters, ratio=ratio,
                    ray_capacity=ray_capacity, capacity=capacity, topology=topology)
    report = _report(plan, shelling, records, len(geometry), topology)
    if output:
        image = phase_image([records[1]], geometry, shelling.table, config, weights=hemisphere.polar_weights, plan=plan)
        with whole_file(output) as part:
            part.write_bytes(image.to_bytes())
    if picture:
        write_png(picture, _picture(plan))
    return report, _text(report)


def _report(plan: Schedule, shelling: Shelling, records: dict, patches: int, topology: str | None) -> dict:
    """What the schedule says, and what castings with it took."""
    frequency, counts = {}, None
    for number, record in records.items():
        frequency[number] = np.zeros(patches, dtype=np.int64)
        _, cast = shelling.cast(record, plan.partition.sections, plan.subshells, references=frequency[number])
        counts = counts or cast
    estimated, tests = plan.estimated, np.array([one.tests for one in counts])
    report = {
        "patches": patches, "found": len(plan.found.patches), "resident": len(plan.sets),
        "balance": {"estimated": _balance(estimated), "true": _balance(tests),
                    "rays": _balance([one.rays for one in counts]),
                    "estimated_cell_steps": _balance(plan.estimated_steps),
                    "cell_steps": _balance([one.cell_steps for one in counts])},
        "effectiveness": {str(number): float(effectiveness(dense, plan.found.frequency)[-1])
                          for number, dense in frequency.items()},
        "cuf": {str(number): cumulative_frequency(dense, plan.sets.chosen) for number, dense in frequency.items()},
        "clusters": [{"section": list(map(int, borders)), "processor": int(processor), "rays": one.rays,
                      "estimated_tests": float(expected), "tests": one.tests, "cell_steps": one.cell_steps,
                      "patches": one.patches, "resident": len(held), "subshells": len(listed)}
                     for borders, processor, expected, one, held, listed in zip(
                         plan.partition.levels[-1], plan.processor, estimated, counts, plan.sets.patches,
                         plan.subshells, strict=True)]}
    if topology:
        load = traffic(plan.partition, plan.found.window, plan.cluster)
        report["mean_hops"] = mean_hops(load, Topology.of(topology, len(counts)).hops, plan.processor)
    return report


def _balance(values) -> float:
    """The largest over the mean."""
    values = np.asarray(values, dtype=np.float64)
    return float(values.max() / values.mean()) if values.any() else 1.0


def _text(report: dict) -> str:
    balance = report["balance"]
    lines = [f"{report['found']} of {report['patches']} patches found, {report['resident']} resident",
             f"balance (largest : mean): tests {balance['true']:.3f} (estimated {balance['estimated']:.3f}), "
             f"rays {balance['rays']:.3f}, cell steps {balance['cell_steps']:.3f} (estimated "
             f"{balance['estimated_cell_steps']:.3f})",
             "point  CUF    E(N')"]
    lines += [f"{point:>5}  {cuf:.3f}  {report['effectiveness'][point]:.3f}" for point, cuf in report["cuf"].items()]
    if "mean_hops" in report:
        lines.append(f"links between clusters that share a patch: {report['mean_hops']:.2f} on average")
    columns = ("rays", "estimated_tests", "tests", "cell_steps", "patches", "resident", "subshells", "processor")
    lines += ["", f"{'cluster':>7} {'columns':>9} {'rows':>9} "
              + " ".join(f"{name.replace('_', ' '):>{max(9, len(name))}}" for name in columns)]
    for number, cluster in enumerate(report["clusters"]):
        first, end, top, bottom = cluster["section"]
        lines.append(f"{number:7} {f'{first}-{end - 1}':>9} {f'{top}-{bottom - 1}':>9} " + " ".join(
            f"{cluster[name]:{max(9, len(name))}.0f}" for name in columns))
    return "\n".join(lines)


def _picture(plan: Schedule) -> np.ndarray:
    """A colour for each section; a ray with the most work is twice as bright as one without."""
    work = plan.found.frusta.share(plan.found.tests)
    light = 0.5 + 0.5 * work / max(work.max(), 1e-9)
    colours = np.rint(label_colours(plan.partition.cluster_map) * light[..., None]).astype(np.uint8)
    scale = max(1, PICTURE_WIDTH // plan.partition.columns)
    return colours.repeat(scale, axis=0).repeat(scale, axis=1)
