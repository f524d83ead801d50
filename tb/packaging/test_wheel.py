"""The wheel holds all that the installed commands need: they run from an empty folder, without the checkout."""

import os
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from importlib.metadata import version
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PACKAGES = "golden", "hw", "radiosity"


def sources():
    """Files of the packages, by path from the root."""
    return {path.relative_to(ROOT).as_posix() for package in PACKAGES for path in (ROOT / package).rglob("*")
            if path.is_file() and "__pycache__" not in path.parts}


@pytest.fixture(scope="session")
def wheel(tmp_path_factory):
    """Built from a copy, so that nothing is left in the checkout."""
    copy, output = tmp_path_factory.mktemp("sources"), tmp_path_factory.mktemp("wheel")
    for package in PACKAGES:
        shutil.copytree(ROOT / package, copy / package, ignore=shutil.ignore_patterns("__pycache__"))
    for name in "pyproject.toml", "README.md", "LICENSE":
        shutil.copy(ROOT / name, copy)
    # An older setuptools does not know how a license is named now; pip then gets one for the build.
    isolation = ["--no-build-isolation"] if int(version("setuptools").partition(".")[0]) >= 77 else []
    run(sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", *isolation, "--wheel-dir", output, copy)
    (built,) = output.glob("*.whl")
    return built


@pytest.fixture(scope="session")
def installed(wheel, tmp_path_factory):
    """The folder of the commands of a new environment that has the wheel, and the dependencies of this one."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=False, symlinks=True)
    run(sys.executable, "-m", "pip", "--python", folder / "bin" / "python", "install", "--quiet", "--no-deps",
        "--no-index", wheel)
    (packages,) = folder.glob("lib/python*/site-packages")
    # The checkout itself is not found this way: its editable installation is a .pth file, which only site.py reads.
    (packages / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return folder / "bin"


def run(*command, is_compiled=False, **options):
    environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
    if not is_compiled:
        # To compile the kernels in a new environment takes longer than all that a picture of 16 pixels computes.
        environment["NUMBA_DISABLE_JIT"] = "1"
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_every_file_of_the_packages_is_in_the_wheel(wheel):
    with zipfile.ZipFile(wheel) as archive:
        files = {name for name in archive.namelist() if ".dist-info/" not in name}
    assert files == sources()


def test_installed_commands_use_the_wheel(installed, tmp_path):
    program = "\n".join(f"import {package}\nprint({package}.__file__)" for package in PACKAGES)
    found = run(installed / "python", "-c", program, cwd=tmp_path).split()
    assert len(found) == len(PACKAGES)
    assert all(Path(path).is_relative_to(installed.parent) for path in found)


def test_a_picture_from_an_empty_folder(installed, tmp_path):
    run(installed / "radiosity", "render", "cornell", "--size", "4x4", "--rays", "16x4", "--light-samples", "1",
        "--depth", "1", "--spp", "1", "--max-edge", "1000", "-o", "cornell.png", cwd=tmp_path)
    assert (tmp_path / "cornell.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.nightly
def test_verilog_from_an_empty_folder(installed, tmp_path):
    run(installed / "radiosity", "verilog", "--preset", "tiny", "--top", "router", "-o", "core", cwd=tmp_path)
    assert list((tmp_path / "core").glob("*.v"))


@pytest.mark.nightly
@pytest.mark.parametrize("words", [(), ("machine",)], ids=["here", "machine"])
def test_a_notebook_from_an_empty_folder(installed, tmp_path, words):
    run(installed / "python", Path(__file__).with_name("notebook.py"), *words, is_compiled=True, cwd=tmp_path)
    assert (tmp_path / "room.png").read_bytes().startswith(b"\x89PNG")
