"""A job for an exported core: main memory before the doorbell, its addresses, and what must come out."""

import re
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from golden.base.errors import InputError
from golden.base.output import whole_file
from golden.base.plural import counted
from golden.cast.hemisphere import Hemisphere
from golden.engine.config import Config
from golden.engine.frustum import hemisphere_record
from golden.engine.frustum.frustum_choice import FrustumChoice
from golden.engine.jobs.core_manifest import CoreManifest, read_manifest
from golden.engine.jobs.expected_results import expected_results
from golden.engine.jobs.job import Job
from golden.engine.jobs.job_header import job_header
from golden.engine.jobs.phase_request import phase_request
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.jobs.whole_job import memory_before, whole_job
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.cell_choice import choose_cell
from golden.engine.schedule.job_shelling import job_shelling
from golden.scene.open import open_scene
from golden.scene.scene import Scene

__all__ = ["ImageFrusta", "JobFiles", "job_files", "write_image"]

# Rays of a frustum for each ray cast to schedule it.
RATIO = 16

# Possessive: a place to return to for each number would take a hundred times the memory of the file.
_RESULTS = re.compile(rb"(?:(?:hit|sum)(?: -?[0-9]++)++\n)*+")


@dataclass(frozen=True, kw_only=True)
class ImageFrusta:
    """The frusta of a job: hemispheres on patches or at a point, or a screen.

    Parameters
    ----------
    patches, every_patch
        Hemispheres from the middle of the fronts of these patches, or of all.
    origin, normal, screen, rays
        As of `FrustumChoice`.

    Raises
    ------
    InputError
        Not exactly one of the four kinds is chosen.
    """

    patches: tuple[int, ...] = ()
    every_patch: bool = False
    origin: tuple[float, ...] | None = None
    normal: tuple[float, ...] | None = None
    screen: tuple[int, int] | None = None
    rays: tuple[int, int] = (256, 64)

    def __post_init__(self):
        given = [name for name, value in (
            ("--patch", self.patches), ("--every-patch", self.every_patch), ("--origin", self.origin is not None),
            ("--screen", self.screen)) if value]
        if len(given) != 1:
            raise InputError("image: one of --patch, --every-patch, --origin and --screen must be given, "
                             f"not {' and '.join(given) or 'none'}")
        if (self.origin is None) != (self.normal is None):
            raise InputError("image: --origin and --normal must be given together")

    def records(self, scene: Scene, config: Config):
        """The records of the frusta, the patches in their coordinates, and the weights of a hemisphere's rows.

        Raises
        ------
        InputError
            The scene has no such patch, or a frustum cannot be made.
        """
        if self.origin is not None or self.screen:
            choice = FrustumChoice(origin=self.origin, normal=self.normal, rays=self.rays, screen=self.screen)
            record, geometry, weights = choice.record(scene, config)
            return [record], geometry, weights
        patches = np.arange(len(scene)) if self.every_patch else np.array(self.patches)
        for patch in patches:
            if not 0 <= patch < len(scene):
                raise InputError(f"image: Patch must be 0 to {len(scene) - 1}, not {patch}", parameter="patch")
        points, hemisphere = scene.centres[patches], Hemisphere(*self.rays)
        geometry = PatchGeometry.of(scene, config.numbers, points)
        records = [hemisphere_record(hemisphere, geometry.coordinates, point, scene.normals[patch],
                                     source=int(scene.surface[patch]))
                   for patch, point in zip(patches, points, strict=True)]
        return records, geometry, hemisphere.polar_weights


@dataclass(frozen=True, kw_only=True, eq=False)
class JobFiles:
    """A job as files.

    Parameters
    ----------
    contents
        Bytes by the names of the files: ``job.bin``, ``job.h`` and, if they are requested, the results ``job.txt``.
    job
        The job, of one phase.
    cell
        The cell size, as a share of the scene's longest side.
    about
        The job in a line.
    """

    contents: dict[str, bytes]
    job: Job
    cell: float
    about: str


def job_files(scene: str, frusta: ImageFrusta, core: CoreManifest, *, cell: float | None = None, base: int = 0,
              hits: str = "full", sums: bool = False, expected: bool = False) -> JobFiles:
    """The files of a job for a core; parameters and errors are those of `write_image`."""
    if hits == "none" and not sums:
        raise InputError("image: one of --hits and --sums must be given, not none")
    records, geometry, weights = frusta.records(open_scene(scene), core.config)
    if sums and weights is None:
        raise InputError("image: --sums needs hemispheres: the rays of a screen have no weights")
    if cell is None:
        cell = choose_cell(records[:1], geometry, core.config).cell
    table = job_shelling(geometry, core.config, cell=cell).table
    request = phase_request(records, geometry, table, core.config, ratio=RATIO, weights=weights,
                            hit_format=HitFormat[hits.upper()], sums=sums)
    job = whole_job([request], core.config, base=base)
    memory = memory_before(job)
    about = f"{scene}: {_frusta_text(records)}, {counted(len(geometry), 'patch')}, cell {cell:g}"
    header = job_header(job, core, about=about, size=len(memory))
    contents = {"job.bin": memory, "job.h": header.encode(errors="replace")}  # a scene's name may be no UTF-8
    if expected:
        contents["job.txt"] = "".join(f"{line}\n" for line in expected_results(job)).encode()
    return JobFiles(contents=contents, job=job, cell=cell, about=about)


def write_image(scene: str, frusta: ImageFrusta, manifest: Path, folder: Path, *, cell: float | None = None,
                base: int = 0, hits: str = "full", sums: bool = False, expected: bool = False) -> tuple[dict, str]:
    """Write ``job.bin``, ``job.h`` and, if they are requested, the expected results ``job.txt`` into a folder.

    They replace those of another job in the folder, its results too if none are requested. A ``job.txt`` that holds
    anything else is not touched.

    Parameters
    ----------
    scene
        A name as `open_scene` takes it.
    frusta
        The frusta of the job.
    manifest, folder
        The manifest of the core, and where the files go.
    cell
        Cell size as a share of the scene's longest side; None: the one with the fewest predicted cycles.
    base
        First byte of main memory, rounded up to a multiple of 64.
    hits, sums
        Format of the hits, and whether sums are written.
    expected
        Whether the results are computed.

    Returns
    -------
    The report for JSON, and as lines.

    Raises
    ------
    InputError
        The manifest is none, the core cannot cast the frusta, or the folder's ``job.txt`` holds no results.
    """
    _check_results(folder / "job.txt")
    made = job_files(scene, frusta, read_manifest(manifest), cell=cell, base=base, hits=hits, sums=sums,
                     expected=expected)
    job, contents = made.job, made.contents
    folder.mkdir(parents=True, exist_ok=True)
    with ExitStack() as files:
        for name, data in contents.items():
            files.enter_context(whole_file(folder / name)).write_bytes(data)
    if not expected:
        (folder / "job.txt").unlink(missing_ok=True)
    paths, size = [str(folder / name) for name in contents], len(contents["job.bin"])
    given, = (phase.request for phase in job.phases)
    report = {"output": paths, "scene": scene, "frusta": len(given.records), "rays": sum(map(len, given.records)),
              "patches": len(given.geometry), "cell": made.cell, "descriptors": len(job.descriptors),
              "base": job.base, "bytes": size, "end": job.end}
    return report, "\n".join([f"{made.about}; {counted(len(job.descriptors), 'descriptor')}",
                              f"{size} bytes at {job.base:#x}, memory in use ends at {job.end:#x}", *paths])


def _check_results(path):
    """A file is replaced or deleted only if it holds the results of a job."""
    if path.is_file() and not _RESULTS.fullmatch(path.read_bytes()):
        raise InputError(f"output {str(path)!r}: it holds no results of a job, so it is not replaced")


def _frusta_text(records):
    first = records[0]
    kind = "screen" if first.is_screen else "hemisphere"
    return f"{counted(len(records), kind)} of {first.columns} x {first.rows} rays"
