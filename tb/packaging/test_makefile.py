"""The Makefile's targets."""

import subprocess
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_clean_enters_every_package():
    recipe = subprocess.run(["make", "--dry-run", "clean"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    line, = (line for line in recipe.splitlines() if line.startswith("find "))
    packages = {path.parent.name for path in ROOT.glob("*/__init__.py")}
    assert packages <= set(line[:line.index(" -name")].split())
