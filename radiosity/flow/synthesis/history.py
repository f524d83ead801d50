"""Area and clock of units by commit, in docs/figures/history.csv: `python -m hw report BLOCK --record`."""

import csv
import subprocess
from dataclasses import astuple, dataclass, fields
from pathlib import Path

from golden.base.errors import InputError
from golden.base.output import whole_file
from golden.engine.config import PRESETS
from radiosity.flow.synthesis.report import Row

__all__ = ["HISTORY", "MACHINE", "ROOT", "Commit", "Record", "add_record", "last_records", "machine_parameters",
           "measured_commit", "read_history"]

ROOT = Path(__file__).parents[3]
HISTORY = ROOT / "docs" / "figures" / "history.csv"
# Block and unit of the machine of a bitstream: an engine, its memory and its host.
MACHINE = "board", "BoardShell"
# What figures depend on.
_SOURCES = ("hw", "golden", "radiosity/flow", "pyproject.toml")


@dataclass(frozen=True, kw_only=True)
class Commit:
    """What was measured, and of which day it is."""

    name: str
    date: str


@dataclass(frozen=True, kw_only=True)
class Record:
    """A line of the history.

    Parameters
    ----------
    commit, date, tools
        What was measured, of which day it is, and with which tools.
    family, preset, parameters, block, unit
        What it is of; ``parameters`` are those that differ from the preset's.
    latency
        In cycles, if it has one.
    lut, ff, dsp, bram
        As in `Area`.
    options, routing, seeds, mhz
        Options of nextpnr; ``timing-driven``, ``routability-driven``, or ``wirelength-driven`` of a bitstream; seeds of
        the placer, and the clock of each; empty if it was not placed.
    mhz_grade_8
        The clock of the same routes on a device of speed grade 8; empty where it was not analysed.
    """

    commit: str
    date: str
    tools: str
    family: str
    preset: str
    parameters: str
    block: str
    unit: str
    latency: int | None
    lut: int
    ff: int
    dsp: int
    bram: int
    options: str
    routing: str
    seeds: tuple[int, ...]
    mhz: tuple[float, ...]
    mhz_grade_8: tuple[float, ...]

    @classmethod
    def of(cls, row: Row, measured: Commit, **where: str) -> "Record":
        """Of a unit's figures."""
        area = row.area
        return cls(commit=measured.name, date=measured.date, unit=row.unit, latency=row.latency, lut=area.lut,
                   ff=area.ff, dsp=area.dsp, bram=area.bram, seeds=tuple(clock.seed for clock in row.clocks),
                   mhz=tuple(round(clock.mhz, 1) for clock in row.clocks),
                   mhz_grade_8=tuple(round(clock.mhz_grade_8, 1) for clock in row.clocks if clock.mhz_grade_8),
                   **where)

    @property
    def key(self) -> tuple[str, ...]:
        """What it is of."""
        return self.family, self.preset, self.parameters, self.block, self.unit

    @property
    def routes(self) -> str:
        """Which routes its clock is of: that of several is their median."""
        seeds = ", ".join(map(str, self.seeds))
        return f"median of seeds {seeds}" if len(self.seeds) > 1 else f"seed {seeds}"


_NUMBERS = {"latency": lambda text: int(text) if text else None, "lut": int, "ff": int, "dsp": int, "bram": int,
            "seeds": lambda text: tuple(map(int, text.split())),
            **dict.fromkeys(("mhz", "mhz_grade_8"), lambda text: tuple(map(float, text.split())))}


def machine_parameters(preset: str, assignments: tuple[str, ...]) -> str:
    """The parameters of a record of a machine of one cluster, from those that were given beside the preset."""
    clusters = () if PRESETS[preset].noc.clusters == 1 else ("noc.columns=1", "noc.rows=1")
    return " ".join((*(one for one in assignments if one not in clusters), *clusters))


def measured_commit(root: Path = ROOT) -> Commit:
    """The commit that is checked out.

    Raises
    ------
    InputError
        There is none, or a file that figures depend on differs from it.
    """
    try:
        changed = _git(root, "status", "--porcelain", "--", *_SOURCES)
        name, date = _git(root, "log", "-1", "--abbrev=10", "--format=%h %cs").split()
    except (OSError, subprocess.CalledProcessError):
        raise InputError("report: figures are recorded of a commit, and here is none") from None
    if changed:
        raise InputError(f"report: figures are recorded of a commit: {changed.split()[1]} is not committed")
    return Commit(name=name, date=date)


def read_history(path: Path = HISTORY) -> list[Record]:
    """All of it, the oldest first."""
    if not path.exists():
        return []
    with path.open(newline="") as file:
        return [Record(**{name: _NUMBERS.get(name, str)(text) for name, text in line.items()})
                for line in csv.DictReader(file)]


def last_records(history: list[Record]) -> dict[tuple[str, ...], Record]:
    """By what it is of, the last one."""
    return {record.key: record for record in history}


def add_record(record: Record, path: Path = HISTORY) -> None:
    """Write it at the end; what the same commit had of the same unit goes."""
    kept = [one for one in read_history(path) if (one.commit, one.key) != (record.commit, record.key)]
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as part, part.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(field.name for field in fields(Record))
        for one in [*kept, record]:
            writer.writerow(" ".join(map(str, value)) if isinstance(value, tuple) else value for value in astuple(one))


def _git(root, *arguments):
    return subprocess.run(["git", "-C", root, *arguments], capture_output=True, text=True, check=True).stdout
