"""Hits of a million rays in each of five scenes against two references that share nothing with the machine.

``radiosity bench reference_hits`` writes out/bench/reference_hits.md. A ray that differs from the integer rule, or from
exact geometry beyond the bounds of docs/exactness.md, makes it fail. Scene, rays and seed suffice to repeat a row.
"""

from collections import Counter

import click
import numpy as np

from benchmarks.independent_hits import exact_geometry, rule_hits
from benchmarks.report import benchmark, provenance, table, write_report
from benchmarks.truth.exact_geometry import CAUSES
from benchmarks.viewpoints import CONFIG, hard_records
from golden.cast.embree import Embree
from golden.cast.grid import Grid
from golden.engine.cast.differences import oracle_rays
from golden.engine.cast.shelling import Shelling
from golden.scene.open import open_scene
from radiosity.cli.console import console

SCENES = ("cornell", "lobby", "room1627", "man", "teapot:4")
CELL = 0.0625
ORIGINS = 8
# Rays of the smallest grids, and by what each side of them may be multiplied.
HEMISPHERE, PIXELS, SCALES = (64, 16), (32, 26), (1, 2, 4, 8)
HEAD = ["scene", "patches", "rays", "hit", "integer rule", *CAUSES, "1/t beyond", "largest share of bound: edge", "1/t",
        "dropped", "float64", "Embree"]


def measure(name: str, scale: int, seed: int) -> Counter:
    """Counts of one scene, and the largest shares of the bounds."""
    scene, counts = open_scene(name), Counter(dict.fromkeys(CAUSES, 0))
    geometry, records = hard_records(scene, origins=ORIGINS, rays=tuple(scale * side for side in HEMISPHERE),
                                     pixels=tuple(scale * side for side in PIXELS), seed=seed)
    shelling = Shelling(geometry, CONFIG, cell=CELL)
    snapped = scene.with_parts(np.arange(len(scene)), geometry.coordinates.points(geometry.vertices))
    casters = {"float64": Grid(snapped, jobs=1), "Embree": Embree(snapped)}
    counts["patches"] = len(scene)
    for record in records:
        hits, _ = shelling.cast(record)
        rule, exact = rule_hits(record, geometry), exact_geometry(record, geometry)
        counts["integer rule"] += np.count_nonzero(np.any(
            [getattr(hits, field) != values for field, values in vars(rule).items()], axis=0))
        verdict = exact.verdict(hits.patch, hits.inverse)
        counts.update(verdict.causes)
        counts.update({"rays": len(record), "hit": np.count_nonzero(hits.patch >= 0), "1/t beyond": verdict.beyond,
                       "dropped": np.count_nonzero(exact.dropped)})
        counts["edge share"] = max(counts["edge share"], verdict.edge)
        counts["1/t share"] = max(counts["1/t share"], verdict.depth)
        rays = oracle_rays(record, geometry)
        for caster, one in casters.items():
            patch = one.nearest_patches(rays) if caster == "Embree" else one.nearest(rays).patch
            counts[caster] += np.count_nonzero((patch != exact.patch) & ~exact.dropped)
    return counts


def row(name: str, counts: Counter) -> list:
    """The row of a scene, or of all."""
    return [name, counts["patches"] or "-", counts["rays"], f"{counts['hit'] / counts['rays']:.2f}",
            counts["integer rule"], *(counts[cause] for cause in CAUSES), counts["1/t beyond"],
            f"{counts['edge share']:.2f}", f"{counts['1/t share']:.2f}", counts["dropped"], counts["float64"],
            counts["Embree"]]


@benchmark("reference_hits", SCENES)
@click.option("--scale", type=click.Choice([str(scale) for scale in SCALES]), default=str(SCALES[-1]),
              show_default=True, help="Multiply the sides of the smallest grids, which have 15,680 rays in all.")
@click.option("--seed", default=1, show_default=True, help="Set the seed of the origins and cameras.")
def main(scenes: tuple[str, ...], scale: str, seed: int) -> None:
    """Count the rays that differ from both references; SCENES default to five built-in ones."""
    rows, total = [], Counter()
    for name in scenes:
        counts = measure(name, int(scale), seed)
        shares = {share: max(total[share], counts[share]) for share in ("edge share", "1/t share")}
        total.update(counts)
        total.update({share: value - total[share] for share, value in shares.items()})
        rows.append(row(name, counts))
        console().note(" | ".join(map(str, rows[-1])))
    total["patches"] = 0
    explained = sum(total[cause] for cause in CAUSES) - total["unexplained"]
    write_report(
        "Hits against references that share nothing with the machine", provenance("numpy", "embreex") + ".",
        f"Seed {seed}; each scene from {ORIGINS} origins (on patches, at vertices, next to edges, anywhere), from each "
        "of them a hemisphere and a screen, and the scene's own view, cast by shelling with cells of "
        f"{CELL:g}.",
        ["* *integer rule*: rays of which any field (patch, 1/t, u, v) differs from the rule of docs/fixed-point.md, "
         "written again in Python's integers. Must be 0.",
         "* *tie* to *unexplained*: rays that hit another patch than in rational geometry of the snapped vertices and "
         "the grid's directions, by cause. *Unexplained* must be 0.",
         "* *1/t beyond*: rays on the same patch whose 1/t is off by more than its bound. Must be 0. The shares are "
         "the largest parts of the bounds that occurred.",
         "* *dropped*: rays that would meet a dropped patch first; the others behind it are compared.",
         "* *float64*, *Embree*: rays, but for those, that these cast to another patch than exact geometry."],
        table(HEAD, [*rows, row("all", total)]),
        f"{total['rays']} rays: {total['integer rule']} differ from the integer rule, {explained} from exact geometry "
        f"within the bounds, {total['unexplained'] + total['1/t beyond']} beyond; float64 {total['float64']}, "
        f"Embree {total['Embree']}.")
    if total["integer rule"] or total["unexplained"] or total["1/t beyond"]:
        raise SystemExit("error: there are differences that must not be")
