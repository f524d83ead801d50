"""Tests that share an expensive fixture run in one process."""

import os
import subprocess
import sys
from pathlib import Path

CONFTEST = Path(__file__).parents[1] / "conftest.py"
TESTS = """
import os

import pytest


@pytest.fixture(scope="module")
def expensive():
    return 0


@pytest.mark.parametrize("number", range(6))
def test_shared(number, expensive):
    with open("processes", "a") as file:
        file.write(f"{os.getpid()}\\n")
"""


def test_a_module_fixture_is_made_once(tmp_path):
    (tmp_path / "conftest.py").write_text(CONFTEST.read_text())
    (tmp_path / "test_shared.py").write_text(TESTS)
    done = subprocess.run([sys.executable, "-m", "pytest", "-p", "xdist", "-n", "2", "--dist", "loadgroup", "-q", "."],
                          cwd=tmp_path, env={"PATH": os.environ["PATH"], "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"},
                          capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    processes = (tmp_path / "processes").read_text().split()
    assert len(processes) == 6
    assert len(set(processes)) == 1
