"""What commands print: one JSON object, nothing when they are quiet, warnings on stderr."""

import json
import subprocess
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

import radiosity.cli.main
from golden.light.factors.files import write_view_factors
from tb.golden.light.factors.samples import three_sides

FLOOR = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nf 1 4 3 2\nf 5 6 7\n"
# Of commands whose own tests do not read the object: arguments, and keys that it has.
REPORTS = {
    "exchange": (("exchange", "duct.npz", "duct.csv", "-o", "heat.csv"), {"output", "surfaces", "heat_to_sky"}),
    "cast": (("cast", "furnace:1", "--patch", "0", "--rays", "16x4", "--compare", "naive"), {"rays", "hits", "naive"}),
    "scene": (("scene", "tetra:1", "-o", "a.obj"), {"output", "patches"}),
    "stimulus": (("stimulus", "icu.reciprocal", "-n", "3", "-o", "a.npz"), {"output", "header"}),
    "verilog": (("verilog", "--top", "router", "--preset", "tiny", "-o", "core"), {"output"}),
    "registers": (("registers",), {"page"}),
    "registers in a file": (("registers", "-o", "registers.md"), {"output"}),
}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where outputs go; view factors are there."""
    monkeypatch.chdir(tmp_path)
    write_view_factors(three_sides(surface=np.array(["a", "b", "b"])), tmp_path / "duct.npz")
    (tmp_path / "duct.csv").write_text("surface,temperature,emissivity\na,300,0.5\nb,400,0.9\n")
    return tmp_path


def run(*arguments):
    result = CliRunner().invoke(radiosity.cli.main.main, [str(argument) for argument in arguments])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exc_info
    return result


@pytest.mark.parametrize("name", REPORTS)
def test_json_is_one_object(folder, name):
    arguments, keys = REPORTS[name]
    result = run(*arguments, "--json")
    assert result.exit_code == 0, result.stderr
    report = json.loads(result.stdout)
    assert keys <= set(report)
    assert not result.stderr


# ruff lets nothing but the command line print.
@pytest.mark.parametrize("name", ["cast", "exchange", "scene", "registers"])
def test_quiet_prints_nothing(folder, name):
    result = run(*REPORTS[name][0], "-q")
    assert (result.exit_code, result.stdout, result.stderr) == (0, "", "")


def test_the_group_is_quiet_too(folder):
    assert run("-q", "config", "tiny").stdout == ""


def test_quiet_and_verbose_exclude_each_other(folder):
    result = run("scenes", "-q", "-v")
    assert result.exit_code == 2
    assert result.stderr == ("error: --quiet and --verbose exclude each other. Try 'main scenes --help'.\n")


@pytest.mark.parametrize(("arguments", "says"), [
    (("--patch", "0"), "the front of patch 0 faces away from the scene"),
    (("--origin", "0.5,0.5,0", "--normal", "0,0,-1"), "the hemisphere faces away from the scene")])
def test_a_cast_without_hits_says_why(folder, arguments, says):
    (folder / "room.obj").write_text(FLOOR)
    result = run("cast", "room.obj", "--rays", "16x4", *arguments)
    assert result.exit_code == 0
    assert result.stdout.startswith("0 of 64 rays hit")
    assert result.stderr.startswith("warning: no ray hits a patch: ")
    assert says in result.stderr
    assert result.stderr.count("\n") == 1


def test_a_cast_with_hits_or_towards_patches_does_not_warn(folder):
    (folder / "room.obj").write_text(FLOOR)
    assert run("cast", "room.obj", "--rays", "16x4", "--origin", "0.5,0.5,0.1", "--normal", "0,0,1").stderr == ""
    # No other winding would help a patch that is alone.
    (folder / "alone.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    assert run("cast", "alone.obj", "--rays", "16x4", "--patch", "0").stderr == ""
    # The triangle is in front of the hemisphere, and all rays miss it.
    assert run("cast", "room.obj", "--rays", "4x4", "--origin", "-5,-5,0.9", "--normal", "0,0,1").stderr == ""


@pytest.mark.parametrize("command", ["demo", "pictures"])
@pytest.mark.parametrize("flag", ["-h", "--help"])
def test_help_renders_nothing(folder, command, flag):
    before = sorted(folder.iterdir())
    result = run(command, flag)
    assert result.exit_code == 0
    assert "FOLDER" in result.stdout
    assert sorted(folder.iterdir()) == before


def test_a_failing_step_ends_the_pictures_with_its_code(folder, monkeypatch):
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: SimpleNamespace(returncode=3))
    result = run("pictures", "made")
    assert result.exit_code == 3


def test_pictures_report_their_files(folder, monkeypatch):
    commands = []

    def record(words, **_):
        commands.append(words)
        return SimpleNamespace(returncode=0)

    monkeypatch.setattr(subprocess, "run", record)
    result = run("pictures", "made", "--json")
    report = json.loads(result.stdout)
    assert len(report["output"]) == len(commands)
    assert commands[-1][3:6] == ["render", "cornell", "--size"]
    assert "--method" in commands[-1]
    assert commands[-1][-1] == "--quiet"
