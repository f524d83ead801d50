"""Rays per second of the casting methods beside Embree, one thread each.

``radiosity bench casting -o out/bench/casting.md`` casts the primary rays of each scene's camera (512 x 512) and
diffuse rays (from random hit points of the primary ones, distributed by the cosine) with ``grid``, ``naive`` and Embree
through embreex, checks that they agree, and writes a table.
"""

import time
from pathlib import Path

import click
import numpy as np

from golden.cast.grid import Grid
from golden.cast.methods import ray_caster
from golden.cast.naive import Naive
from golden.cast.rays import Rays
from golden.commands.console import console
from golden.frustum import Screen, frame
from golden.scene.open import open_scene
from radiosity.benchmarks.report import output_option, provenance, write_report

SEED = 1
SIDE = 512
# Naive is given this many ray-patch tests, a second or two.
NAIVE_TESTS = 40_000_000
REPEATS = 3


def primary_rays(scene) -> Rays:
    """One ray through the centre of each pixel."""
    return Screen(camera=scene.camera, width=SIDE, height=SIDE).rays()


def diffuse_rays(scene, caster, rays: Rays) -> Rays:
    """As many rays, from points that ``rays`` hit, distributed by the cosine on the side that was hit."""
    random = np.random.default_rng(SEED)
    hits = caster.nearest(rays)
    met = random.choice(np.flatnonzero(hits.patch >= 0), len(rays))
    patch = hits.patch[met]
    normal = scene.normals[patch]
    normal *= -np.sign(np.einsum("rj,rj->r", normal, rays.direction[met]))[:, None]
    angle, radius2 = random.random(len(met)) * 2 * np.pi, random.random(len(met))
    local = np.stack([np.sqrt(radius2) * np.cos(angle), np.sqrt(radius2) * np.sin(angle), np.sqrt(1 - radius2)], axis=1)
    return Rays(rays.origin[met] + hits.t[met, None] * rays.direction[met],
                np.einsum("rk,rki->ri", local, frame(normal)), source=scene.surface[patch])


def rate(cast, rays: Rays) -> tuple[float, object]:
    """Rays per second of processor time, the best of a few runs, and what the last one gave."""
    best = np.inf
    for _ in range(REPEATS):
        begin = time.process_time()
        result = cast(rays)
        best = min(best, time.process_time() - begin)
    return len(rays) / best, result


def measure(name: str) -> list[str]:
    """Table rows of a scene."""
    scene = open_scene(name)
    begin = time.process_time()
    grid = Grid(scene, jobs=1)
    building = time.process_time() - begin
    naive, embree = Naive(scene), ray_caster(scene, "embree")
    rows = []
    first = primary_rays(scene)
    for kind, rays in (("primary", first), ("diffuse", diffuse_rays(scene, grid, first))):
        few = rays[np.linspace(0, len(rays) - 1, max(1, NAIVE_TESTS // len(scene)), dtype=int)[:len(rays)]]
        grid_rate, hits = rate(grid.nearest, rays)
        naive_rate, judged = rate(naive.nearest, few)
        embree_rate, _ = rate(embree.nearest_patches, rays)
        if not np.array_equal(judged.patch, grid.nearest(few).patch):
            raise SystemExit(f"error: {name}: grid and naive disagree")
        cells = " x ".join(str(count) for count in grid.cells.shape)
        rows.append(f"| {name} | {len(scene)} | {kind} | {len(rays)} | {cells} | {building:.2f} "
                    f"| {hits.tests.mean():.2f} | {hits.steps.mean():.2f} | {grid_rate / 1e6:.3f} "
                    f"| {naive_rate / 1e6:.5f} | {embree_rate / 1e6:.2f} | {grid_rate / naive_rate:.0f} "
                    f"| {embree_rate / grid_rate:.1f} |")
    return rows


@click.command()
@click.argument("scenes", nargs=-1)
@output_option("casting")
def main(scenes: tuple[str, ...], output: Path) -> None:
    """Compare the casting methods with Embree; SCENES default to seven built-in ones."""
    lines = [
        "# Casting: million rays per second of one processor core",
        "",
        f"{provenance('numpy', 'embreex')}; seed {SEED}, {SIDE} x {SIDE} rays, best of {REPEATS} runs, "
        "processor time.",
        "",
        "| scene | patches | rays | count | cells | build s | tests/ray | steps/ray | grid | naive | Embree "
        "| grid : naive | Embree : grid |",
        "|---" * 13 + "|",
    ]
    for name in scenes or ("cornell", "lobby", "room1627", "cubes", "man", "phone", "tetra"):
        rows = measure(name)
        lines += rows
        console().note("\n".join(rows))
    write_report(output, lines)
