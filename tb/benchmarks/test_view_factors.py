"""The benchmark of view factors."""

import json
import math
import multiprocessing
import time
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks import view_factor_programs, view_factors
from benchmarks.view_factor_cases import plate_between_plates
from benchmarks.view_factor_programs import PROGRAMS, compute, in_own_process
from golden.base.peak_memory import peak_memory
from radiosity.cli.main import main as radiosity


def test_tables(tmp_path, monkeypatch):
    monkeypatch.setattr(view_factors, "in_own_process", lambda function, *arguments, **_: function(*arguments))
    monkeypatch.setattr(view_factors, "OPEN", view_factors.OPEN[:1])
    monkeypatch.setattr(view_factors, "COVERED_WIDTHS", (0.4,))
    monkeypatch.setattr(view_factors, "HIDDEN", (partial(plate_between_plates, 0.4),))
    monkeypatch.setattr(view_factors, "method_rows", lambda facets, **given: [["none", 0.5, 0, 0.0, 0.1]])
    monkeypatch.setattr(view_factor_programs, "PROGRAMS", {
        "none": ("no_such_module", None), "this package": PROGRAMS["this package"]})
    monkeypatch.setattr(view_factors, "PROGRAMS", view_factor_programs.PROGRAMS)
    case = plate_between_plates()
    monkeypatch.setattr(view_factors, "compared", lambda: [("plates", case.facets, given, 0.02)
                                                           for given in (case, None)])
    result = CliRunner().invoke(radiosity, ["bench", "view_factors", "furnace:1", "--seeds", "2", "--json", "--error",
                                            "0.05", "-o", str(tmp_path / "x.md")])
    assert result.exit_code == 0, result.output
    closed, hidden, coverage, methods, scenes, programs = (one["rows"] for one in json.loads(result.stdout)["tables"])
    assert [list(row.values())[2:] for row in closed] == [["< 1e-9"] * 3]
    assert [row["requested"] for row in hidden] == [0.01, 0.001]
    assert all(row["median"] <= row["largest"] < 3 * row["requested"] for row in hidden)
    assert [row["factors"] for row in coverage] == [2, 2, 4, 4, 12]
    assert coverage[0]["2"] in ("0%", "50%", "100%")
    assert methods == [{"method": "none", "closure": 0.5, "below 0": 0, "exact factors move by": "< 1e-9",
                        "RMS error": 0.1}]
    assert "measured" in (tmp_path / "x-coverage.svg").read_text()
    assert [scenes[0][name] for name in ("scene", "rows", "entries", "closure", "reciprocity", "open rows")] == [
        "furnace:1", 6, 30, "< 1e-9", "< 1e-9", 0]
    assert [row["program"] for row in programs] == ["none", "this package"] * 2
    assert {row["error"] for row in programs[::2]} == {"not installed"}
    assert [row["error"] == "" for row in programs[1::2]] == [False, True]


def test_a_program_that_is_not_installed_gives_nothing(monkeypatch):
    monkeypatch.setitem(PROGRAMS, "none", ("no_such_module", None))
    assert compute("none", plate_between_plates().facets, 0.1) is None


def test_this_package_is_measured():
    found = compute("this package", plate_between_plates().facets, 0.05)
    assert (found.F.sum(axis=1) + found.sky + found.rest).tolist() == pytest.approx([1, 1, 1])
    assert found.memory > 1 << 20


def test_a_program_runs_in_a_process_of_its_own_with_its_own_memory():
    here = np.ones(1 << 26)
    assert in_own_process(peak_memory) < here.nbytes < peak_memory()


def test_what_takes_too_long_is_stopped():
    begin = time.monotonic()
    with pytest.raises(TimeoutError, match=r"sleep took more than 0\.1 s"):
        in_own_process(time.sleep, 60, seconds=0.1)
    assert time.monotonic() - begin < 60


def test_an_error_in_a_process_is_raised_here(monkeypatch):
    """In one that begins at once, and is this one."""
    def process(target, args):
        return SimpleNamespace(start=lambda: target(*args), kill=lambda: None, join=lambda: None)

    monkeypatch.setattr(multiprocessing, "get_context", lambda kind: SimpleNamespace(
        Pipe=multiprocessing.Pipe, Process=process))
    assert in_own_process(math.sqrt, 4) == 2
    with pytest.raises(ValueError, match="math domain error"):
        in_own_process(math.sqrt, -1)


def test_a_program_that_is_stopped_has_a_row(monkeypatch):
    def stop(*_, seconds):
        raise TimeoutError

    monkeypatch.setattr(view_factors, "in_own_process", stop)
    rows = view_factors.program_rows("plates", plate_between_plates().facets, None, 0.1, 9.0)
    assert [row[2:5] for row in rows] == [[program, "stopped after 9 s", ""] for program in PROGRAMS]
