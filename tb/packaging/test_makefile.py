"""The Makefile's targets."""

import subprocess
from pathlib import Path

from tb.bugs.nearness import simulated

ROOT = Path(__file__).parents[2]


def test_clean_enters_every_package():
    recipe = subprocess.run(["make", "--dry-run", "clean"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    line, = (line for line in recipe.splitlines() if line.startswith("find "))
    packages = {path.parent.name for path in ROOT.glob("*/__init__.py")}
    assert packages <= set(line[:line.index(" -name")].split())


def test_the_regressions_have_all_folders_of_the_hardware():
    folders = {path.parent.name for path in ROOT.glob("hw/*/__init__.py")}
    assert {f"tb/{name}" for name in folders} <= {*simulated(ROOT)}
