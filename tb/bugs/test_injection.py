"""Bugs are applied one at a time, exactly once, and their results stay."""

import json
import subprocess

import pytest
from click.testing import CliRunner

from tb.bugs.injection import main, near_tests, read_list

BUG = """[[bug]]
id = "{id}"
class = "sums"
file = "golden/sums.py"
old = '{old}'
new = '{new}'
does = "a wrong sum"
"""
GOOD = BUG.format(id="minus", old="a + b", new="a - b") + BUG.format(id="order", old="a + b", new="b + a")


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A repository with one function and its test."""
    files = {
        "golden/__init__.py": "", "golden/sums.py": "def total(a, b):\n    return a + b\n",
        "tb/golden/test_sums.py": "from golden.sums import total\n\n\ndef test_total():\n    assert total(3, 1) == 4\n",
        "tb/system/test_machine.py": "from golden import sums\n\n\ndef test_zero():\n    assert not sums.total(0, 0)\n",
        "Makefile": "test: lint ## fast\n\t@echo tests\n\tpytest -n 2 -m \"not nightly\"\n",
        "pytest.ini": "[pytest]\nmarkers = nightly\n", ".gitignore": "build/\nout/\n"}
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    identity = ["-c", "user.name=a", "-c", "user.email=a@b"]
    for words in ["init", "-q"], ["add", "."], [*identity, "commit", "-qm", "All"]:
        subprocess.run(["git", *words], cwd=tmp_path, check=True)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    return tmp_path


def run(project, text, *words):
    (project / "list.toml").write_text(text)
    return CliRunner().invoke(main, ["list.toml", *words])


def test_a_bug_is_killed_and_one_that_changes_nothing_survives(project):
    output = run(project, GOOD).output
    assert "minus: killed by tb/golden/test_sums.py::test_total" in output
    assert "order: SURVIVED" in output
    assert (project / "out/bench/list.md").read_text().startswith("1 of 2 killed; 2 in the list.")
    assert (project / "golden/sums.py").read_text().count("a + b") == 1
    # Only survivors run again, and only in other tests.
    assert run(project, GOOD).output == ""
    assert run(project, GOOD, "--whole").output.startswith("order: SURVIVED")


def test_the_tests_of_whole_machines_follow_those_near_a_bug(project):
    late = BUG.format(id="late", old="a + b", new="a + b + (a == 0)")
    assert "late: SURVIVED" in run(project, late).output
    assert "late: killed by tb/system/test_machine.py::test_zero" in run(project, late, "--whole").output
    tests = json.loads((project / "build/bugs/list.json").read_text())["late"]["tests"]
    assert tests == ["tb/golden/test_sums.py", "tb/golden", "tb/system"]


@pytest.mark.parametrize("is_compiled", [False, True])
def test_a_bug_of_compiled_code_has_a_cache_of_its_own(project, is_compiled):
    """A shared cache has the compiled callers in other files, which would hide the bug."""
    if is_compiled:
        (project / "golden/sums.py").write_text("# @compiled\ndef total(a, b):\n    return a + b\n")
    (project / "tb/golden/test_sums.py").write_text(
        "import os\n\n\ndef test_cache():\n    assert not os.environ.get('NUMBA_CACHE_DIR', '').endswith('order')\n")
    subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", "commit", "-qam", "Cache"], cwd=project,
                   check=True)
    order = BUG.format(id="order", old="a + b", new="b + a")
    assert ("order: killed" if is_compiled else "order: SURVIVED") in run(project, order).output


@pytest.mark.parametrize("old", ["a * b", "a"])
def test_a_text_that_is_not_in_the_file_once_is_reported_and_the_others_run(project, old):
    result = run(project, BUG.format(id="x", old=old, new="b") + GOOD)
    assert result.exit_code == 1
    assert "minus: killed" in result.output
    assert "1 of 3 bugs do not fit their files:\nText of bug x must be in golden/sums.py once" in result.output


def test_tests_that_fail_without_a_bug_are_refused(project):
    (project / "tb/golden/test_sums.py").write_text("def test_total():\n    assert 0\n")
    subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", "commit", "-qam", "Break"], check=True)
    assert "test_total fails without a bug" in run(project, GOOD).output
    assert "no such tests: missing.py" in run(project, GOOD, "--tests", "missing.py").output


def test_an_id_that_is_not_in_the_list_is_named_before_anything_runs(project):
    result = run(project, GOOD, "--ids", "minus,sign")
    assert result.exit_code == 2
    assert result.output.endswith("Error: --ids: list.toml has no bug sign\n")
    assert not (project / "build").exists()


def test_ids_differ_and_fields_are_complete(project):
    for text in GOOD.replace("order", "minus"), GOOD.replace("class", "group"):
        (project / "list.toml").write_text(text)
        with pytest.raises(ValueError, match=r"of (bugs must differ, not be minus twice|a bug must be)"):
            read_list(project / "list.toml")


def test_tests_of_a_folder_without_any_are_those_above(project):
    assert near_tests("golden/ctu/unit.py", project) == ["tb/golden"]
    assert near_tests("golden/sums.py", project) == ["tb/golden/test_sums.py", "tb/golden"]


@pytest.mark.parametrize("file", ["hw/machine.py", "hw/simulator/port.py", "hw/engine.py"])
def test_what_has_no_folder_is_tested_with_whole_machines(project, file):
    own = ["tb/system/test_machine.py"] if file == "hw/machine.py" else []
    assert near_tests(file, project) == [*own, "tb/system"]
