"""Shelling against brute force, and fixed point against the oracle, on all built-in scenes.

``radiosity bench exactness`` writes out/bench/exactness.md; an unexplained difference makes it fail. Scene and
seed suffice to repeat a row.
"""

from collections import Counter
from dataclasses import replace

import click
import numpy as np

from benchmarks.report import benchmark, provenance, table, write_report
from benchmarks.viewpoints import CONFIG, halves, hard_records
from golden.cast.grid import Grid
from golden.engine.cast.differences import differences, oracle_rays
from golden.engine.cast.fixed_hits import FixedHits
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.cast.shelling import Shelling
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.patch_setup import PatchSetup
from golden.engine.memsys.patches.patch_table import PatchTable
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.builtin import BUILTIN
from golden.scene.open import open_scene
from golden.scene.scene import Scene
from radiosity.cli.console import console

CELLS = (0.5, 0.125, 0.0625)
CLUSTERS = (1, 2, 4, 8, 16)
ORDERS = 20
ORIGINS, RAYS, PIXELS = 8, (256, 64), (96, 72)
CAUSES = ("edge", "long_edge", "depth", "dropped", "unexplained")


def shuffled(table: PatchTable, count: np.ndarray, seed: int) -> PatchTable:
    """The patches of each cell in another order."""
    entries = table.read(np.arange(len(table)))
    cell = np.repeat(np.arange(len(count)), count)
    return PatchTable(entries[np.lexsort((np.random.default_rng(seed).random(len(entries)), cell))])


def order_differences(shelling: Shelling, records, expected, seed: int) -> int:
    """Rays that differ from those of brute force, over `ORDERS` orders and all of `CLUSTERS`."""
    straight, wrong = shelling.table.patches, 0
    for order in range(ORDERS):
        shelling.table.patches = shuffled(straight, shelling.table.count, seed + order)
        number = order % len(records)
        clusters = CLUSTERS[order % len(CLUSTERS)]
        hits, _ = shelling.cast(records[number], sectors=halves(records[number], clusters))
        wrong += len(hits.differences(expected[number]))
    shelling.table.patches = straight
    for clusters in CLUSTERS:
        for record, reference in zip(records[::4], expected[::4], strict=True):
            wrong += len(shelling.cast(record, sectors=halves(record, clusters))[0].differences(reference))
    return wrong


def oracle_differences(fixed: FixedHits, grid: Grid, record: FrustumRecord, scene: Scene,
                       geometry: PatchGeometry) -> Counter:
    """Rays that hit another patch than the oracle's, by cause.

    Where the oracle hits a patch that the machine drops, it is tried again without all such patches.
    """
    rays = oracle_rays(record, geometry)
    oracle = grid.nearest(rays)
    found = differences(fixed, oracle, record, scene, geometry, CONFIG)
    causes, again = Counter(found.counts()), found.dropped
    if len(again):
        kept = np.flatnonzero(~PatchSetup(record, CONFIG).patches(geometry).factor.dropped)
        rest = scene.with_parts(kept)
        behind = Grid(rest, grid.cells.size / scene.size, jobs=1).nearest(rays[again]).patch
        patch = fixed.patch.copy()
        patch[again] = np.where(behind >= 0, kept[behind], -1)
        second = differences(fixed, replace(oracle, patch=patch), record, scene, geometry, CONFIG)
        causes.update(second.counts())
    return causes


def measure(name: str, seed: int) -> tuple[list, bool]:
    """The row of a scene, and whether nothing in it must not be."""
    scene = open_scene(name)
    geometry, records = hard_records(scene, origins=ORIGINS, rays=RAYS, pixels=PIXELS, seed=seed)
    naive, grid = NaiveFixed(geometry, CONFIG), Grid(scene, jobs=1)
    expected = [naive.cast(record) for record in records]
    wrong, shelling = [], None
    for cell in CELLS:
        shelling = Shelling(geometry, CONFIG, cell=cell)
        wrong.append(sum(len(shelling.cast(record)[0].differences(hits))
                         for record, hits in zip(records, expected, strict=True)))
    wrong.append(order_differences(shelling, records, expected, seed))
    causes = Counter()
    for record, hits in zip(records, expected, strict=True):
        causes.update(oracle_differences(hits, grid, record, scene, geometry))
    rays = sum(map(len, records))
    hit = sum(np.count_nonzero(hits.patch >= 0) for hits in expected)
    row = [name, len(scene), seed, len(records), rays, f"{hit / rays:.2f}", *wrong, *(causes[one] for one in CAUSES),
           f"{1e6 * (sum(causes.values()) - causes['dropped']) / rays:.0f}"]
    return row, not any(wrong) and not causes["unexplained"]


@benchmark("exactness", tuple(BUILTIN))
@click.option("--seed", default=1, help="Set the seed of the origins, cameras and orders.")
def main(scenes: tuple[str, ...], seed: int) -> None:
    """Count the rays that differ from brute force; SCENES default to all built-in scenes."""
    rows, are_fine = [], True
    for name in scenes:
        row, is_fine = measure(name, seed)
        are_fine &= is_fine
        rows.append(row)
        console().note(" ".join(map(str, row)))
    write_report(
        "Exactness: rays that differ", provenance("numpy") + ".",
        f"Each scene from {ORIGINS} origins (on patches, at vertices, next to edges, anywhere), from each of them a "
        f"hemisphere of {RAYS[0]} x {RAYS[1]} rays and a screen of {PIXELS[0]} x {PIXELS[1]} with a field of view of "
        "20, 60 or 100 degrees, and the scene's own view.",
        ["* *cell*: rays of which any field (patch, 1/t, u, v) of shelling differs from brute force in the same "
         "integers. Must be 0.",
         f"* *orders*: the same with the finest cells, the patches of each cell in {ORDERS} random orders on "
         f"{', '.join(map(str, CLUSTERS))} clusters, and a quarter of the frusta on each number of clusters. Must be "
         "0.",
         "* The rest: rays of which fixed point hits another patch than the float64 oracle, by cause "
         "(`golden.engine.cast.differences`), and all but *dropped* per million rays. *Dropped* are rays that leave a "
         "vertex or a point of a patch that is not named as their source: float64 meets it at the origin itself, and "
         "is tried again without such patches; what differs then counts too. *Unexplained* must be 0."],
        table(["scene", "patches", "seed", "frusta", "rays", "hit", *(f"cell {cell}" for cell in CELLS), "orders",
               *(cause.replace("_", " ") for cause in CAUSES), "per million"], rows))
    if not are_fine:
        raise SystemExit("error: there are differences that must not be")
