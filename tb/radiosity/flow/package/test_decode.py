"""The decoders beside an exported engine: distances, positions and form factors of a job are those of its scene."""

import subprocess
import sys

import numpy as np
import pytest

from golden.cast.default_camera import default_camera
from golden.cast.frame import frame
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.scene.open import open_scene
from tb.radiosity.cli.golden.runner import run
from tb.radiosity.flow.package.exported_engine import NAME

RAYS, PATCH = (32, 8), 4


def decode(language, core, job, text):
    """Run a decoder on the results of a job."""
    example = core / "example"
    command = [sys.executable, example / "decode.py", job / "job.h"]
    if language == "c":
        command = [example / "decode"]
        subprocess.run(["gcc", "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{job}", "-o", *command,
                        example / "decode.c", "-lm"], check=True)
    return subprocess.run(command, input=text, capture_output=True, text=True)


def decoded(language, core, job):
    """What a decoder prints of a job: hits and sums as numbers."""
    text = (job / "job.txt").read_text()
    done = decode(language, core, job, text)
    assert done.returncode == 0, done.stderr
    lines = [line.split() for line in done.stdout.splitlines()]
    assert sum(line[0] == "hit" for line in lines) == sum(
        line.startswith("hit") and line.split()[4] != "-1" for line in text.splitlines())
    return [np.array([line[1:] for line in lines if line[0] == kind], dtype=float) for kind in ("hit", "sum")]


def check_points(hits, scene, origin, directions):
    """Origin and distance along the ray give the point that u and v give on the patch, to the steps of the numbers."""
    _, column, row, patch, distance, u, v = hits.T
    corners = scene.vertices[patch.astype(int)]
    along = corners[:, 0] + u[:, None] * (corners[:, 1] - corners[:, 0])
    across = corners[:, 3] + u[:, None] * (corners[:, 2] - corners[:, 3])
    places = along + v[:, None] * (across - along)
    points = origin + distance[:, None] * directions[row.astype(int), column.astype(int)]
    size = np.linalg.norm(corners[:, 2] - corners[:, 0], axis=1) + np.linalg.norm(corners[:, 3] - corners[:, 1], axis=1)
    # Half a step of 2^-8 in u and in v, and what rounded directions and vertices move a point.
    assert (np.linalg.norm(points - places, axis=1) < 2.0**-8 * size + 2.0**-12 * distance).all()
    # The plane alone is met to the digits of the stored distance.
    normal = scene.normals[patch.astype(int)]
    steepness = np.abs(np.einsum("ij,ij->i", normal, points - origin)) / distance
    error = np.abs(np.einsum("ij,ij->i", normal, points - corners[:, 0]))
    assert (error < 2.0**-13 * distance + 2.0**-16 * distance / steepness).all()


@pytest.mark.parametrize("language", ["python", "c"])
def test_a_hemisphere(language, core):
    hits, sums = decoded(language, core, core / "job")
    scene, hemisphere = open_scene("cornell"), Hemisphere(*RAYS)
    directions = (hemisphere.directions @ frame(scene.normals[PATCH])).reshape(RAYS[1], RAYS[0], 3)
    check_points(hits, scene, scene.centres[PATCH], directions)
    factors = np.zeros(len(scene))
    weights = np.repeat(hemisphere.polar_weights, RAYS[0]) / 2.0**hemisphere.weight_bits
    np.add.at(factors, hits[:, 3].astype(int), weights[(hits[:, 2] * RAYS[0] + hits[:, 1]).astype(int)])
    _, patch, factor = sums.T
    assert np.allclose(factors[patch.astype(int)], factor, rtol=1e-8, atol=0)
    assert np.isclose(factor.sum(), factors.sum())


def screen_job(core, folder, hits="full", size=(16, 12)):
    """A job of a screen, with its expected results."""
    arguments = ["image", "cornell", "--manifest", core / f"{NAME}.json", "--screen", f"{size[0]}x{size[1]}",
                 "--cell", "0.5", "--hits", hits, "--expected", "-o", folder]
    assert run(*arguments).exit_code == 0
    return folder


def test_a_screen(core, tmp_path):
    """Its distances are depths."""
    size = 16, 12
    hits, sums = decoded("python", core, screen_job(core, tmp_path / "job", size=size))
    assert not len(sums)
    scene = open_scene("cornell")
    rays = Screen(camera=scene.camera or default_camera(scene), width=size[0], height=size[1]).rays()
    check_points(hits, scene, rays.origin[0], rays.direction.reshape(size[1], size[0], 3))


@pytest.mark.parametrize("language", ["python", "c"])
def test_every_format_of_hits_is_decoded(language, core, tmp_path):
    """To the same patches; those that have the patch alone without a point."""
    full, compact, ids = (decoded(language, core, screen_job(core, tmp_path / name, name))[0]
                          for name in ("full", "compact", "ids"))
    assert full.shape[1] == compact.shape[1] == 7
    assert ids.tolist() == full[:, :4].tolist() == compact[:, :4].tolist()


@pytest.mark.parametrize("language", ["python", "c"])
@pytest.mark.parametrize("line", ["hit 0 0 0", "hit 0 0 0 1 2", "hit 0 0 0 1 2 3", "sum 0 1", "hits 0 0 0 1", "error"])
def test_any_other_line_is_an_error(language, core, line):
    done = decode(language, core, core / "job", f"{line}\n")
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr
