"""The ``image`` command: what it prints and writes, and what it refuses."""

import tracemalloc

import numpy as np
import pytest

from golden.engine.config import PRESETS
from golden.engine.jobs.descriptor import DESCRIPTOR
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.memory_map import from_bytes
from radiosity.cli.golden.choices import HIT_FORMATS
from radiosity.flow.job_image import write_image
from tb.golden.engine.jobs.manifests import write_manifest
from tb.radiosity.cli.golden.runner import report, run

CONFIG = PRESETS["tiny"].replace({
    "noc.columns": 1, "noc.rows": 1, "memsys.scene_cells": 1024, "memsys.own_cells": 1024})
SMALL = ("--rays", "32x8", "--cell", 0.5)


@pytest.fixture
def manifest(tmp_path):
    return write_manifest(tmp_path / "core.json", CONFIG)


def test_a_hemisphere_is_a_load_and_its_sections(manifest, tmp_path):
    folder = tmp_path / "new" / "image"
    printed = report("image", "cornell", "--manifest", manifest, "--patch", 4, *SMALL, "--base", "0x1000", "--expected",
                     "-o", folder)
    assert printed["output"] == [str(folder / name) for name in ("job.bin", "job.h", "job.txt")]
    memory = (folder / "job.bin").read_bytes()
    assert (printed["base"], printed["bytes"], printed["rays"]) == (0x1000, len(memory), 256)
    descriptors = np.frombuffer(memory, dtype=DESCRIPTOR.dtype, count=printed["descriptors"])
    image = int(descriptors["hits"][0]) - 0x1000
    size = int.from_bytes(memory[image + 8:image + 16], "little")
    assert len(from_bytes(memory[image:image + size])["patches"]) == printed["patches"] == 20
    assert "#define RADIOSITY_JOB_BASE UINT64_C(0x1000) " in (folder / "job.h").read_text()
    assert len((folder / "job.txt").read_text().splitlines()) == 256


def test_the_same_files_every_time(manifest, tmp_path):
    given = ("image", "cornell", "--manifest", manifest, "--patch", 4, "--patch", 5, *SMALL, "--sums", "--hits", "none")
    for name in "ab":
        assert run(*given, "-o", tmp_path / name).exit_code == 0
    for name in "job.bin", "job.h":
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    assert not (tmp_path / "a" / "job.txt").exists()


def test_results_of_another_job_do_not_stay(manifest, tmp_path):
    given = ("image", "cornell", "--manifest", manifest, "--patch", 4, *SMALL, "-o", tmp_path)
    report(*given, "--expected")
    assert (tmp_path / "job.txt").exists()
    printed = report(*given)
    assert not (tmp_path / "job.txt").exists()
    assert printed["output"] == [str(tmp_path / name) for name in ("job.bin", "job.h")]


@pytest.mark.parametrize("more", [(), ("--expected",)])
def test_a_file_that_holds_no_results_stays_as_it_is(manifest, tmp_path, more):
    mine = tmp_path / "job.txt"
    mine.write_text("hit 0 0 0 4 1 2 3\nmy notes\n")
    result = run("image", "cornell", "--manifest", manifest, "--patch", 4, *SMALL, *more, "-o", tmp_path)
    assert (result.exit_code, result.stderr) == (
        2, f"error: output {str(mine)!r}: it holds no results of a job, so it is not replaced\n")
    assert mine.read_text() == "hit 0 0 0 4 1 2 3\nmy notes\n"
    assert not (tmp_path / "job.bin").exists()


def test_results_are_recognised_in_little_more_memory_than_they_take(tmp_path):
    size = (tmp_path / "job.txt").write_text("hit 0 12 13 4055 123456 17 200\n" * 30000)
    tracemalloc.start()
    with pytest.raises(FileNotFoundError, match="none"):
        write_image("cornell", None, tmp_path / "none.json", tmp_path)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 4 * size


@pytest.mark.parametrize(("frusta", "count", "rays"), [
    (("--every-patch", *SMALL), 20, 256), (("--screen", "30x20"), 1, 600),
    (("--origin", "0.5,0.5,0.5", "--normal", "0,0,1", *SMALL), 1, 256)])
def test_frusta_that_can_be_chosen(frusta, count, rays, manifest, tmp_path):
    printed = report("image", "cornell", "--manifest", manifest, "--hits", "ids", *frusta, "-o", tmp_path)
    assert (printed["frusta"], printed["rays"]) == (count, count * rays)


def test_the_text_says_the_same_as_the_json(manifest, tmp_path):
    given = ("image", "cornell", "--manifest", manifest, "--patch", 4, *SMALL, "-o", tmp_path)
    printed, text = report(*given), run(*given).stdout
    assert text.startswith("cornell: 1 hemisphere of 32 x 8 rays, 20 patches, cell 0.5; 2 descriptors\n"
                           f"{printed['bytes']} bytes at 0x0, memory in use ends at {printed['end']:#x}\n")


@pytest.mark.parametrize(("arguments", "message"), [
    ((), "one of --patch, --every-patch, --origin and --screen must be given, not none"),
    (("--patch", 1, "--screen", "8x8"), "not --patch and --screen"),
    (("--origin", "0,0,0"), "--origin and --normal must be given together"),
    (("--patch", 20), "--patch: Patch must be 0 to 19, not 20"), (("--patch", -1), "not -1"),
    (("--screen", "8x8", "--sums"), "--sums needs hemispheres"),
    (("--screen", "8x8", "--rays", "8x8"), "--rays does not go with --screen"),
    (("--patch", 1, "--hits", "none"), "one of --hits and --sums must be given"),
    (("--patch", 1, "--base", "-64"), "'-64' is not a whole number from 0 on"),
    (("--patch", 1, "--base", "0x"), "'0x' is not a whole number from 0 on"),
    (("--patch", 1, "--base", "0xfffffffff000"), "(memory.address_bits)"),
    (("--patch", 1, "--rays", "4096x1024"), "Columns and rows must be at most"),
    (("--patch", 1, "--cell", "0.05"), "(memsys.scene_cells)"),
    (("--patch", 1, "--manifest", "nowhere.json"), "nowhere.json"),
    (("--patch", 1, "--manifest", __file__), "it is no manifest of an engine")])
def test_what_is_refused(arguments, message, manifest, tmp_path):
    folder = tmp_path / "image"
    result = run("image", "cornell", "--manifest", manifest, "-o", folder, *arguments)
    assert result.exit_code == 2
    assert message in result.stderr
    assert result.stderr.count("\n") == 1
    assert not folder.exists()


def test_formats_that_can_be_chosen_are_those_of_the_machine():
    assert tuple(one.name.lower() for one in HitFormat) == HIT_FORMATS
