"""The simulation beside an exported engine: it compiles, and prints the results of the golden model."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from golden.base.errors import InputError
from radiosity.flow.package.core_files import core_files, write_core
from radiosity.flow.package.manifest import manifest
from radiosity.flow.package.software.sample_job import SAMPLE
from radiosity.flow.simulator.verilator import verilator_package
from tb.golden.engine.jobs.manifests import write_manifest
from tb.radiosity.cli.golden.runner import run
from tb.radiosity.flow.package.driver_library import complaints
from tb.radiosity.flow.package.exported_engine import CONFIG, NAME, WIDE, make

ROOT = Path(__file__).parents[4]


def pin(port):
    """The member that Verilator's model has for a port."""
    width = port["width"]
    kind = next((kind for most, kind in ((8, "CData"), (16, "SData"), (32, "IData"), (64, "QData")) if width <= most),
                f"VlWide<{-(-width // 32)}>")
    return f"    {kind} {port['name']};\n"


@pytest.mark.parametrize("config", [CONFIG, WIDE], ids=["64 bits", "256 bits"])
def test_the_simulation_compiles_without_a_warning(config, exported, without_verilog, monkeypatch, tmp_path):
    """With the ports of the manifest as Verilator declares them, and the job of `exported`."""
    job = {path.name: path.read_bytes() for path in (exported / "job").iterdir()}
    monkeypatch.setattr("radiosity.flow.package.software.software_files.sample_job", lambda *_, **__: job)
    write_core("engine", config=config, preset="tiny", folder=tmp_path)
    ports = manifest("engine", NAME, config=config, preset="tiny", text="")["ports"]
    (tmp_path / f"V{NAME}.h").write_text(
        f'#include "verilated.h"\nstruct V{NAME} {{\n    explicit V{NAME}(VerilatedContext *);\n    void eval();\n'
        + "".join(map(pin, ports)) + "};\n")
    include = verilator_package() / "share" / "verilator" / "include"
    assert not complaints(
        tmp_path, "g++", "-std=c++17", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-I.", "-Idriver", "-Ijob",
        "-isystem", include, "-isystem", include / "vltstd", "example/main.cpp")
    assert not complaints(
        tmp_path, "gcc", "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-fsyntax-only", "-Idriver", "-Ijob",
        "example/cast_job.c")


def test_the_sample_is_what_the_command_writes(exported, tmp_path):
    sha256 = re.search(r'JOB_CORE "(\w+)"', (exported / "job" / "job.h").read_text())[1]
    path = write_manifest(tmp_path / "core.json", CONFIG, sha256=sha256)
    scene, *options = shlex.split(SAMPLE)
    assert run("image", scene, "--manifest", path, *options, "-o", tmp_path / "job").exit_code == 0
    for name in "job.bin", "job.h", "job.txt":
        assert (tmp_path / "job" / name).read_bytes() == (exported / "job" / name).read_bytes()
    assert (exported / "job" / "job.txt").read_text().count("hit") == 256
    assert sha256 in (exported / f"{NAME}.json").read_text()


@pytest.mark.parametrize("missing", ["job.h", "job.bin"])
@pytest.mark.parametrize(("folder", "target"), [("example", "run"), ("litex_soc", "run"), ("litex_soc", "board")])
def test_a_folder_without_a_job_is_refused(folder, target, missing, core):
    (core / "job" / missing).unlink()
    # The engine, compiled before; nothing of it is older than a file that it is made from.
    for made in f"build/engine/V{NAME}__ALL.a", "build/gateware/obj_dir/Vsim", "ulx3s/gateware/top.v":
        path = core / folder / made
        path.parent.mkdir(parents=True)
        path.touch()
    done = subprocess.run(["make", "-C", folder, target], cwd=core, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "JOB must be a folder with the job.h and job.bin of `radiosity image`, not ../job" in done.stderr


def test_an_engine_that_is_too_small_has_no_sample(exported, without_verilog, monkeypatch):
    def refuse(*_, **given):
        raise InputError("memory image: Patches must be at most 16 (icu.patch_bits), not 20")

    assert "`job/job.bin`" in (exported / "README.md").read_text()
    monkeypatch.setattr("radiosity.flow.package.software.sample_job.job_files", refuse)
    files = core_files("engine", config=CONFIG, preset="tiny")
    assert not [name for name in files if name.startswith("job/")]
    assert "sim:" not in files[f"{NAME}.core"]
    assert "`job/job.bin`" not in files["README.md"]


def test_every_file_is_named_in_the_readme(exported):
    files = {path.relative_to(exported).as_posix(): path.read_bytes() for path in exported.rglob("*") if path.is_file()}
    rows = re.findall(r"(?m)^\| (`.*) \|$", files["README.md"].decode())
    named = {word for row in rows for word in re.findall(r"`([^`]+)`", row)}
    for name in files:
        assert {name, os.path.splitext(name)[1], os.path.basename(name)} & named or name == "README.md", name
    assert not re.search(rb"@\w+@", b"".join(text for name, text in files.items() if not name.endswith(".bin")))


def test_exported_python_has_the_style_of_the_project(exported):
    paths = sorted(exported.rglob("*.py"))
    assert [path.name for path in paths] == ["decode.py", "radiosity_soc.py", "simulation.py", "ulx3s.py"]
    done = subprocess.run([sys.executable, "-m", "ruff", "check", "--config", ROOT / "pyproject.toml", *paths],
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def run_fusesoc(folder):
    """What FuseSoC's simulation of a core prints."""
    path = f"{verilator_package() / 'bin'}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run([Path(sys.executable).with_name("fusesoc"), "--cores-root", ".", "run", "--target=sim",
                           f"radiosity::{NAME}"], cwd=folder, capture_output=True, text=True, check=False,
                          env=os.environ | {"PATH": path})
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.nightly
def test_an_exported_engine_casts_in_a_simulation_made_of_its_files_alone(tmp_path):
    """The sample; then a job of twenty frusta elsewhere in memory, with other hits; a wrong hit is noticed."""
    folder = tmp_path / "core"
    subprocess.run([sys.executable, "-m", "hw", "verilog", "--preset", "tiny", "-P", "noc.columns=1", "-P",
                    "noc.rows=1", "-o", folder], check=True)
    assert "2 descriptors in " in make(folder / "example", "check")
    found = [line for line in run_fusesoc(folder).splitlines() if line.startswith(("hit", "sum"))]
    assert found == (folder / "job" / "job.txt").read_text().splitlines()
    job = tmp_path / "job"
    assert run("image", "cornell", "--manifest", folder / f"{NAME}.json", "--every-patch", "--rays", "32x8", "--base",
               "0x123456000", "--sums", "--hits", "compact", "--expected", "-o", job).exit_code == 0
    assert "21 descriptors in " in make(folder / "example", "check", f"JOB={job}")
    expected = (job / "job.txt").read_text()
    (job / "job.txt").write_text(expected.replace("hit 3 7 5 ", "hit 3 7 6 ", 1))
    with pytest.raises(AssertionError, match="differ"):
        make(folder / "example", "check", f"JOB={job}")
