"""Rays per second of the casting methods beside Embree's own interface, per second of processor time.

``radiosity bench casting -o out/bench/casting.md`` casts the primary rays of each scene's camera (512 x 512) and
diffuse rays (from random hit points of the primary ones, distributed by the cosine), these for any hit as well, with
``grid``, ``naive`` and ``embree``, with Embree's own interface in single precision and with the binding embreex. It
checks that the first three agree, and writes a table.
"""

import time

import numpy as np

from benchmarks.bare_embree import BareEmbree
from benchmarks.float32_causes import CAUSES, float32_causes
from benchmarks.report import benchmark, provenance, table, write_report
from golden.cast.frame import frame
from golden.cast.grid import Grid
from golden.cast.methods import ray_caster
from golden.cast.naive import Naive
from golden.cast.rays import Rays
from golden.cast.screen import Screen
from golden.scene.open import open_scene
from radiosity.cli.console import console

SEED = 1
SIDE = 512
# Naive is given this many ray-patch tests, a second or two.
NAIVE_TESTS = 40_000_000
# Runs at least, and seconds of them.
REPEATS, SECONDS = 3, 0.2


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


def shortest(run, clock) -> tuple[float, object]:
    """The shortest of several runs in seconds of a clock, and what the last one gave."""
    begin, times = clock(), []
    while len(times) < REPEATS or clock() - begin < SECONDS:
        start = clock()
        result = run()
        times.append(clock() - start)
    return min(times), result


def rate(cast, rays: Rays) -> tuple[float, object]:
    """Rays per second of processor time, and what the last run gave."""
    seconds, result = shortest(lambda: cast(rays), time.process_time)
    return len(rays) / seconds, result


def binding(scene):
    """A function from rays to the patches that Embree meets first, by the binding embreex."""
    from embreex.mesh_construction import TriangleMesh
    from embreex.rtcore_scene import EmbreeScene

    corners = (scene.vertices - scene.bounds[0]) / scene.size
    triangles = np.concatenate([corners[:, :3], corners[~scene.is_triangle][:, [0, 2, 3]]])
    held = EmbreeScene()
    mesh = TriangleMesh(held, triangles.reshape(-1, 3).astype(np.float32),
                        np.arange(3 * len(triangles), dtype=np.int32).reshape(-1, 3))

    def cast(rays):
        assert mesh is not None  # the scene does not hold it
        origin = ((rays.origin - scene.bounds[0]) / scene.size).astype(np.float32)
        return held.run(origin, rays.direction.astype(np.float32))

    return cast


def measure(name: str) -> list[list]:
    """Table rows of a scene."""
    scene = open_scene(name)
    grid, naive = Grid(scene, jobs=1), Naive(scene)
    one, two = (ray_caster(scene, "embree", jobs=jobs) for jobs in (1, 2))
    bare, bound = BareEmbree(scene), binding(scene)
    rows, first = [], primary_rays(scene)
    diffuse = diffuse_rays(scene, grid, first)
    for kind, rays, any_hit in (("primary", first, False), ("diffuse", diffuse, False), ("any hit", diffuse, True)):
        few = rays[np.linspace(0, len(rays) - 1, max(1, NAIVE_TESTS // len(scene)), dtype=int)[:len(rays)]]
        grid_rate, hits = rate(grid.any_hit if any_hit else grid.nearest, rays)
        one_rate, found = rate(one.blocked if any_hit else one.nearest, rays)
        two_rate, _ = rate(two.blocked if any_hit else two.nearest, rays)
        prepared = bare.prepared(rays)
        bare_rate, _ = rate(lambda rays, prepared=prepared, any_hit=any_hit: bare.cast(*prepared, any_hit=any_hit),
                            rays)
        bound_rate = "" if any_hit else f"{rate(bound, rays)[0] / 1e6:.2f}"
        naive_rate, judged = rate(naive.nearest, few)
        if not np.array_equal(judged.patch >= 0, (grid.any_hit if any_hit else grid.nearest)(few).patch >= 0):
            raise SystemExit(f"error: {name}: grid and naive disagree")
        if any_hit:
            wrong = rays[np.flatnonzero(found != (hits.patch >= 0))]
            causes = float32_causes(scene, wrong, one.any_hit(wrong), grid.any_hit(wrong))
        else:
            causes = float32_causes(scene, rays, found, hits)
        rows.append([name, len(scene), kind, len(rays), f"{hits.tests.mean():.2f}", f"{hits.steps.mean():.2f}",
                     f"{naive_rate / 1e6:.5f}", *(f"{one / 1e6:.2f}" for one in (
                         grid_rate, one_rate, two_rate, bare_rate)), bound_rate, f"{one_rate / bare_rate:.2f}",
                     *(causes[cause] for cause in CAUSES)])
        console().note(" ".join(map(str, rows[-1])))
    return rows


@benchmark("casting", ("cornell", "lobby", "room1627", "cubes", "man", "tetra", "balls:3", "city"))
def main(scenes: tuple[str, ...]) -> None:
    """Compare the casting methods with Embree; SCENES default to eight built-in ones."""
    rows = [row for name in scenes for row in measure(name)]
    write_report(
        "Casting: million rays per second of processor time",
        f"{provenance('numpy', 'embreex')}; seed {SEED}, {SIDE} x {SIDE} rays, best of {REPEATS} runs or more. "
        "Bare: Embree's own interface, single precision, first patch alone. Last columns: rays with another hit by "
        "embree than by grid. Within single precision's band a hit is of the ray's start, or of the border of its "
        "patch, or the patch is seen edge-on, or the two patches are that near to each other.",
        table(["scene", "patches", "rays", "count", "tests/ray", "steps/ray", "naive", "grid", "embree", "2 threads",
               "bare", "binding", "embree : bare", *CAUSES], rows))
