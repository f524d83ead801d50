"""Hits, pictures, form factors, memory images and stimuli stay what they are, byte for byte.

docs/records/outputs.csv lists commands with the digest of what they write. `python -m
tb.golden.commands.test_outputs` prints the list anew: for a change that is meant to change results, and says so.
"""

import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from tb.golden.commands.outputs import digest

RECORD = Path(__file__).parents[3] / "docs" / "records" / "outputs.csv"
COLUMNS = ("command", "digest")
with RECORD.open(newline="") as file:
    RECORDED = {row["command"]: row["digest"] for row in csv.DictReader(file)}
# One of each kind; `make nightly` runs the others.
QUICK = ("cast cornell", "cast lobby", "schedule lobby", "formfactors furnace")


def written(command: str, folder: Path) -> str:
    """The digest of what ``python -m golden COMMAND`` writes."""
    subprocess.run([sys.executable, "-m", "golden", *command.split()], cwd=folder, check=True, capture_output=True)
    return digest(folder)


@pytest.mark.parametrize("command", [
    pytest.param(command, marks=[] if command.startswith(QUICK) else pytest.mark.nightly) for command in RECORDED])
def test_output_stays(command, tmp_path):
    assert written(command, tmp_path) == RECORDED[command], (
        f"python -m golden {command} writes other results than {RECORD.name} records")


if __name__ == "__main__":
    rows = csv.writer(sys.stdout, lineterminator="\n")
    rows.writerow(COLUMNS)
    for command in RECORDED:
        with tempfile.TemporaryDirectory() as folder:
            rows.writerow((command, written(command, Path(folder))))
