"""The history of area and clock: a line per unit and commit."""

import subprocess
from dataclasses import replace
from pathlib import PurePath

import pytest

from golden.base.errors import InputError
from radiosity.flow.synthesis.family import Area
from radiosity.flow.synthesis.flow import Clock
from radiosity.flow.synthesis.history import Commit, Record, add_record, last_records, measured_commit, read_history
from radiosity.flow.synthesis.report import Row
from tb.sources.source_texts import loaded_files

ROW = Row(unit="Unit", latency=7, area=Area(lut=100, ff=50, dsp=2, bram=1),
          clocks=tuple(Clock(seed=seed, mhz=mhz, path="a to b", mhz_grade_8=mhz + 30)
                       for seed, mhz in ((1, 101.26), (2, 99.04))))
WHERE = {"tools": "one 1, two 2", "family": "ecp5", "preset": "small", "parameters": "icu.rays=64", "block": "icu",
         "options": "--placer-heap-timingweight 30", "routing": "timing-driven"}


def record(name="a" * 10, **changes):
    return replace(Record.of(ROW, Commit(name=name, date="2026-11-21"), **WHERE), **changes)


def test_what_is_written_is_read(tmp_path):
    path = tmp_path / "figures" / "history.csv"
    assert read_history(path) == []
    bitstream = replace(ROW, clocks=tuple(replace(clock, mhz_grade_8=None) for clock in ROW.clocks))
    given = [record(), Record.of(bitstream, Commit(name="b" * 10, date="2026-11-22"), **WHERE),
             record(unit="Area", latency=None, seeds=(), mhz=(), mhz_grade_8=(), options="", routing="")]
    for one in given:
        add_record(one, path)
    assert read_history(path) == given
    assert given[0].mhz == (101.3, 99.0)
    assert given[0].mhz_grade_8 == (131.3, 129.0)
    assert (given[1].mhz, given[1].mhz_grade_8) == ((101.3, 99.0), ())
    assert len(path.read_text().splitlines()) == 4


def test_the_last_record_of_a_unit_counts(tmp_path):
    path = tmp_path / "history.csv"
    for one in (record(lut=1), record("b" * 10, lut=2), record("b" * 10, unit="Other"), record("b" * 10, lut=3)):
        add_record(one, path)
    history = read_history(path)
    # The same commit's is measured again.
    assert [(one.commit[0], one.unit, one.lut) for one in history] == [
        ("a", "Unit", 1), ("b", "Other", 100), ("b", "Unit", 3)]
    assert last_records(history)[record().key].lut == 3


def test_figures_are_of_a_commit(tmp_path):
    with pytest.raises(InputError, match="report: figures are recorded of a commit, and here is none"):
        measured_commit(tmp_path)
    git = ["git", "-C", tmp_path, "-c", "user.name=a", "-c", "user.email=a@b"]
    # Of each folder one file that measures, or that is measured.
    made_by = loaded_files("radiosity.flow.synthesis.report", "radiosity.flow.synthesis.cell_report",
                           "radiosity.flow.board.ulx3s")
    sources = sorted({PurePath(path).parent: path for path in sorted(made_by)}.values())
    assert "radiosity" in {path.partition("/")[0] for path in sources}
    for path in (*sources, "pyproject.toml"):
        (tmp_path / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / path).write_text("1\n")
    for command in (["init", "-q"], ["add", "."], ["commit", "-q", "-m", "one", "--date", "2020-02-02T12:00:00Z"]):
        subprocess.run([*git, *command], check=True)
    measured = measured_commit(tmp_path)
    assert len(measured.name) == 10
    # What no figure depends on may change.
    (tmp_path / "README.md").write_text("new\n")
    assert measured_commit(tmp_path) == measured
    for path in (*sources, "pyproject.toml"):
        (tmp_path / path).write_text("2\n")
        with pytest.raises(InputError, match=f"^report: figures are recorded of a commit: {path} is not committed$"):
            measured_commit(tmp_path)
        (tmp_path / path).write_text("1\n")
