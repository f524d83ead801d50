"""The rules of every run of tests."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

RULES = Path(__file__).parents[1] / "conftest.py"
PASSES = "def test_it():\n    pass\n"
ICARUS = "import pytest\n\n\n@pytest.mark.icarus\ndef test_it():\n    pass\n\n\ndef test_other():\n    pass\n"


def run(folder, files, *options, **environment):
    """A run of tests under the rules: its end code, and what it prints."""
    for name, text in {"pytest.ini": "[pytest]\nmarkers = icarus\n", "conftest.py": RULES.read_text(), **files}.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text)
    done = subprocess.run([sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "--import-mode=importlib",
                           "-p", "xdist", *options, "."], cwd=folder, capture_output=True, text=True, check=False,
                          env={**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1", **environment})
    return done.returncode, done.stdout + done.stderr


@pytest.mark.parametrize("options", [(), ("-n", "1")], ids=str)
@pytest.mark.parametrize(("text", "skips"), [
    (f"@pytest.mark.skipif(False, reason='not here')\n{PASSES}", False),
    (f"@pytest.mark.skipif(True, reason='not here')\n{PASSES}", True),
    (f"pytest.skip('not here', allow_module_level=True)\n\n\n{PASSES}", True),
    (f"pytest.importorskip('not_here')\n\n\n{PASSES}", True),
    ("@pytest.mark.xfail\ndef test_it():\n    assert False\n", True)],
    ids=["none", "test", "module", "import", "expected failure"])
def test_a_run_with_a_skipped_test_fails(tmp_path, options, text, skips):
    code, said = run(tmp_path, {"test_it.py": f"import pytest\n\n\n{text}", "test_other.py": PASSES}, *options)
    assert code == int(skips), said
    assert ("error: skipped tests: 1; none may be" in said) == skips


@pytest.fixture
def without_icarus(tmp_path):
    """A PATH with git and Python alone."""
    folder = tmp_path / "programs"
    folder.mkdir()
    (folder / "git").symlink_to(shutil.which("git"))
    return str(folder)


@pytest.mark.parametrize("options", [
    (), pytest.param(("-n", "2"), marks=pytest.mark.nightly)], ids=["one process", "workers"])
def test_cases_for_icarus_are_left_out_and_counted_where_it_is_missing(tmp_path, without_icarus, options):
    code, said = run(tmp_path, {"tb/a/test_it.py": ICARUS, "tb/b/test_it.py": PASSES}, *options, PATH=without_icarus,
                     ICARUS="")
    assert code == 0, said
    assert "2 passed" in said
    assert "tests: a 1, b 1\n" in said
    assert "left out, Icarus Verilog is not installed: 1 tests\n" in said


@pytest.mark.parametrize(("name", "value", "least"), [
    ("SEED", "", 0), ("SEED", "-1", 0), ("SEED", "1.5", 0), ("NIGHTS", "x", 1), ("NIGHTS", "0", 1)])
def test_a_seed_or_a_number_of_nights_that_is_none_ends_the_run_with_one_line(tmp_path, name, value, least):
    code, said = run(tmp_path, {"test_it.py": PASSES}, **{name: value})
    assert (code, said) == (4, f"ERROR: {name} must be an integer of at least {least}, not {value!r}\n\n")


def test_a_run_that_requires_icarus_fails_without_it(tmp_path, without_icarus):
    code, said = run(tmp_path, {"test_it.py": PASSES}, PATH=without_icarus, ICARUS="required")
    assert code == 4, said
    assert "Icarus Verilog is not installed: apt-get install iverilog" in said


def test_cases_for_icarus_run_where_it_is(tmp_path, without_icarus):
    (Path(without_icarus) / "iverilog").symlink_to(sys.executable)
    code, said = run(tmp_path, {"tb/a/test_it.py": ICARUS, "tb/b/test_it.py": PASSES}, PATH=without_icarus,
                     ICARUS="required")
    assert code == 0, said
    assert "tests: a 2, b 1\n" in said
    assert "left out" not in said
