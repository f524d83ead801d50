"""Meshes of growing size: build, rays per second, memory and pictures, beside Embree and Mitsuba.

``radiosity bench mesh_sizes`` measures every scene and method in a process of its own, with one thread: the time to
build, the rays per second of primary and diffuse rays (see `benchmarks.casting`), the most memory, and for
some scenes the time until a picture has the error of ours. Mitsuba needs the extra ``reference``.
"""

import os
import time
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np

from benchmarks.casting import SIDE, diffuse_rays, primary_rays, rate
from benchmarks.report import benchmark, provenance, table, write_report
from benchmarks.view_factor_programs import in_own_process
from golden.base.peak_memory import peak_memory
from golden.cast.grid import Grid
from golden.cast.methods import ray_caster
from golden.cast.rays import Rays
from golden.render.two_pass import RenderSettings, render
from golden.scene.open import open_scene
from radiosity.cli.console import console

__all__ = ["Cast", "Picture", "measure_cast", "relative_error", "samples_of_error"]

METHODS = ("grid", "embree", "mitsuba")
SCENES = ("balls:1", "balls:2", "balls:3", "balls:4", "balls:5")
# Diffuse ones: the path tracer has no mixed materials.
PICTURES = ("cornell", "cubes", "man")
# Pixels along an edge of the pictures, paths per pixel of their reference, and of the run whose error is measured.
PIXELS, REFERENCE, MEASURED = 128, 1024, 64
# Share of the mean radiance below which a pixel's error is no longer relative to its own.
DARK = 0.01


@dataclass(frozen=True, kw_only=True)
class Cast:
    """What a method takes for a scene: seconds, rays per second, bytes."""

    triangles: int
    build: float
    primary: float
    diffuse: float
    memory: int


@dataclass(frozen=True, kw_only=True)
class Picture:
    """What a picture takes: seconds of the processor, its error, bytes; of Mitsuba the samples per pixel too.

    The error is the root of the mean square of the differences from the reference, each relative to its pixel's value.
    """

    seconds: float
    error: float
    memory: int
    samples: int


def measure_cast(name: str, method: str, primary: Rays, diffuse: Rays) -> Cast:
    """Build a scene's structure, and cast rays."""
    scene = open_scene(name)
    begin = time.process_time()
    cast = _caster(scene, method)
    build = time.process_time() - begin
    return Cast(triangles=2 * len(scene) - int(scene.is_triangle.sum()), build=build,
                primary=rate(cast, primary)[0], diffuse=rate(cast, diffuse)[0], memory=peak_memory())


def measure_render(name: str) -> tuple[Picture, np.ndarray]:
    """Our picture with default settings; its error is not known yet."""
    scene = open_scene(name)
    begin = time.process_time()
    image = render(scene, camera=scene.camera, settings=RenderSettings(width=PIXELS, height=PIXELS, jobs=1)).image
    return Picture(seconds=time.process_time() - begin, error=np.nan, memory=peak_memory(), samples=4), image


def measure_paths(name: str, ours: np.ndarray) -> tuple[Picture, float]:
    """Mitsuba's picture of our error, and the error of ours."""
    from benchmarks.path_tracer import PathTracer

    scene = open_scene(name)
    tracer = PathTracer(scene)

    def trace(samples, seed):
        begin = time.process_time()
        image, _ = tracer.trace(width=PIXELS, height=PIXELS, samples=samples, seed=seed)
        return image, time.process_time() - begin

    runs = REFERENCE // MEASURED
    reference = sum(trace(MEASURED, 1 + run)[0] for run in range(runs)) / runs
    memory = peak_memory()
    # The kernel is compiled by now.
    paths, seconds = trace(MEASURED, 0)
    error = relative_error(ours, reference)
    samples = samples_of_error(error, relative_error(paths, reference), MEASURED)
    return Picture(seconds=seconds * samples / MEASURED, error=error, memory=memory, samples=samples), error


def samples_of_error(error: float, measured: float, samples: int) -> int:
    """Samples per pixel that have an error, if so many have the measured one: it falls with their square root."""
    return max(1, round(samples * (measured / error) ** 2))


def relative_error(image: np.ndarray, reference: np.ndarray) -> float:
    """The root of the mean square of pixels' differences, each relative to its value and a hundredth of the mean."""
    return float(np.sqrt((((image - reference) / (reference + DARK * reference.mean())) ** 2).mean()))


def _caster(scene, method):
    """A function that casts rays."""
    if method == "grid":
        return Grid(scene, jobs=1).nearest
    if method == "embree":
        return ray_caster(scene, "embree").nearest_patches
    from benchmarks.mitsuba_rays import MitsubaRays

    return MitsubaRays(scene).nearest


def _alone(function, *arguments):
    """The result of a function with one thread, in a process of its own."""
    os.environ["OMP_NUM_THREADS"] = "1"
    if find_spec("drjit"):
        import drjit
        drjit.set_thread_count(1)
    return function(*arguments)


def _cast_row(name, method, *rays):
    found = in_own_process(_alone, measure_cast, name, method, *rays)
    return [name, found.triangles, method, f"{found.build:.2f}", f"{found.primary / 1e6:.2f}",
            f"{found.diffuse / 1e6:.2f}", f"{found.memory / 1e6:.0f}"]


def _picture_rows(name, with_mitsuba):
    ours, image = in_own_process(_alone, measure_render, name)
    if not with_mitsuba:
        return [[name, "ours", 4, f"{ours.seconds:.1f}", "", f"{ours.memory / 1e6:.0f}"]]
    paths, error = in_own_process(_alone, measure_paths, name, image)
    return [[name, who, one.samples, f"{one.seconds:.1f}", f"{100 * error:.1f} %", f"{one.memory / 1e6:.0f}"]
            for who, one in (("ours", ours), ("mitsuba", paths))]


@benchmark("mesh_sizes", SCENES)
def main(scenes: tuple[str, ...]) -> None:
    """Measure meshes of growing size beside Embree and Mitsuba; SCENES default to five sizes of `balls`."""
    with_mitsuba = find_spec("mitsuba") is not None
    methods = METHODS if with_mitsuba else METHODS[:-1]
    casts, pictures = [], []
    for name in scenes:
        scene = open_scene(name)
        primary = primary_rays(scene)
        diffuse = diffuse_rays(scene, ray_caster(scene, "embree"), primary)
        for method in methods:
            casts.append(_cast_row(name, method, primary, diffuse))
            console().note(" ".join(map(str, casts[-1])))
    for name in PICTURES:
        pictures += _picture_rows(name, with_mitsuba)
        console().note(" ".join(map(str, pictures[-1])))
    if not with_mitsuba:
        console().warn("Mitsuba is not installed (extra `reference`): its rows are left out")
    write_report(
        "Meshes of growing size",
        f"{provenance('numpy', 'embreex', *(['mitsuba'] if with_mitsuba else []))}; {SIDE} x {SIDE} rays, one thread, "
        "processor time.",
        table(["scene", "triangles", "method", "build s", "primary Mrays/s", "diffuse Mrays/s", "peak MB"], casts),
        "## Pictures of equal error",
        table(["scene", "renderer", "samples", "seconds", "error", "peak MB"], pictures))
