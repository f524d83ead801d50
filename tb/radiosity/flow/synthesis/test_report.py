"""What is measured: a netlist for all seeds, a table that says what was counted."""

import json
import os

import pytest
from amaranth.hdl import Fragment
from click.testing import CliRunner

import radiosity.flow.synthesis.report
from golden.engine.config import PRESETS
from radiosity.cli.hw.main import main
from radiosity.flow.synthesis.family import Area
from radiosity.flow.synthesis.flow import OPTIONS, Clock
from radiosity.flow.synthesis.history import Commit
from radiosity.flow.synthesis.report import measure, spread, table

CONFIG = PRESETS["tiny"]
MHZ = {3: 90.2, 5: 120.6, 8: 100.4}
# The best seed of one speed grade need not be that of another.
MHZ_GRADE_8 = {3: 120.2, 5: 130.4, 8: 150.6}


@pytest.fixture
def calls(monkeypatch):
    """The calls of the tools, which are not there; a clock for each seed."""
    found = []

    def synthesised(component, folder):
        Fragment.get(component, None)
        found.append("netlist")
        return folder / "clock.json"

    def synthesised_alone(component, folder, *, family):
        Fragment.get(component, None)
        folder.mkdir(parents=True, exist_ok=True)
        return Area(lut=120, ff=67, dsp=2, bram=1, folded=89)

    def placed(netlist, *, seed, options, routability_driven):
        found.append((netlist.name, seed, options, routability_driven))
        return Clock(seed=seed, mhz=MHZ[seed], path=f"path {seed}", mhz_grade_8=MHZ_GRADE_8[seed])

    monkeypatch.setattr(radiosity.flow.synthesis.report, "synthesise_between_registers", synthesised)
    monkeypatch.setattr(radiosity.flow.synthesis.report, "synthesise", synthesised_alone)
    monkeypatch.setattr(radiosity.flow.synthesis.report, "place_and_route", placed)
    return found


@pytest.fixture
def nextpnr(monkeypatch, tmp_path):
    """A program in place of nextpnr, which takes seconds to start; it has no options but those of the flow."""
    program = tmp_path / "bin" / "nextpnr-ecp5"
    program.parent.mkdir()
    program.write_text("""#!/bin/sh
case "$*" in
*--version*) echo "(Version nextpnr-1.2)";;
*--x*) echo "ERROR: no such option" >&2; exit 1;;
*) echo "Info: Program finished normally.";;
esac
""")
    program.chmod(0o700)
    monkeypatch.setenv("PATH", str(program.parent), prepend=os.pathsep)


def test_one_netlist_is_placed_once_for_each_seed(calls, nextpnr, tmp_path):
    row = measure("ctu", "CellNumber", CONFIG, tmp_path, seeds=tuple(MHZ))
    assert calls == ["netlist", *(("clock.json", seed, OPTIONS, False) for seed in MHZ)]
    assert {clock.seed: clock.mhz for clock in row.clocks} == MHZ
    written = json.loads((tmp_path / "CellNumber" / "row.json").read_text())
    assert [clock["seed"] for clock in written["clocks"]] == list(MHZ)
    text = table([row], block="ctu", preset="tiny", config=CONFIG, family="ecp5", seeds=tuple(MHZ), options=OPTIONS)
    assert "| Fmax (MHz) least / median / best | Fmax on grade 8 (MHz) least / median / best | critical path" in text
    assert "| 90 / 100 / 121 | 120 / 130 / 151 | path 5 (seed 5) |" in text
    assert "placer seeds 3, 5, 8, --placer-heap-timingweight 30; preset tiny" in text
    one = table([row], block="ctu", preset="tiny", config=CONFIG, family="ecp5", seeds=(3,), options=OPTIONS)
    assert "| Fmax (MHz) | Fmax on grade 8 (MHz) | critical path |" in one
    assert "placer seed 3, " in one
    assert one.endswith("; preset tiny.\n")
    changed = table([row], block="ctu", preset="tiny", config=CONFIG.with_parameters(("icu.slots=16",)), family="ecp5",
                    seeds=(3,), options=OPTIONS)
    assert changed.endswith("; preset tiny icu.slots=16.\n")


def test_routes_are_routability_driven_if_the_command_says_so(calls, nextpnr, monkeypatch, tmp_path):
    recorded = []
    monkeypatch.setattr("radiosity.flow.synthesis.history.measured_commit", lambda: Commit(name="a" * 10,
                                                                                           date="2026-11-28"))
    monkeypatch.setattr("radiosity.flow.synthesis.history.add_record", recorded.append)
    command = ["report", "ctu", "--unit", "CellNumber", "--preset", "tiny", "--seed", "8", "--record", "-o", tmp_path]
    for more, routing in ([], "timing-driven"), (["--routability-driven"], "routability-driven"):
        result = CliRunner().invoke(main, [*map(str, command), *more])
        assert result.exit_code == 0, result.output
        assert calls.pop() == ("clock.json", 8, OPTIONS, bool(more))
        assert ("routability-driven routing" in result.output) == bool(more)
        assert recorded[-1].routing == routing
        found = json.loads(CliRunner().invoke(main, [*map(str, command), *more, "--json"]).output)
        assert (found["options"], found["seeds"], found["routability_driven"]) == (list(OPTIONS), [8], bool(more))
        assert found["tools"].startswith("amaranth ")
        assert (found["family"], found["preset"]) == ("ecp5", "tiny")
        calls.pop()


@pytest.mark.parametrize("nothing", [["--no-route"], ["--family", "gowin"]])
@pytest.mark.parametrize("more", [["--seed", "2"], ["--nextpnr", "--router router2"], ["--routability-driven"]])
def test_options_of_a_route_are_refused_without_one(nothing, more, calls, nextpnr, tmp_path):
    command = ["report", "ctu", "--unit", "CellNumber", "--preset", "tiny", "-o", str(tmp_path), *nothing, *more]
    result = CliRunner().invoke(main, command)
    assert (result.exit_code, result.output) == (2, f"error: report: {more[0]} needs place and route\n")
    assert not calls


REPORT = ["report", "ctu", "--unit", "CellNumber"]
REFUSED = [("--frequency 9", "unrecognised option '--frequency'\n"), ("--placer", "option '--placer' is missing\n"),
           ("--router none", "Router algorithm 'none' is not supported"), ("--help", "refuses "), ("--25k", "refuses "),
           ("--seed 7", "option '--seed' cannot be specified more than once\n")]


def refused(options, error, calls, folder, *, command=REPORT):
    """A command ends before anything is made."""
    result = CliRunner().invoke(main, [*command, "-o", str(folder / "out"), "--nextpnr", options])
    assert result.exit_code == 2
    assert error in result.output
    assert result.output.startswith("error: ")
    assert result.output.count("\n") == 1
    assert not calls
    assert not (folder / "out").exists()


def test_options_must_be_words_of_a_shell(calls, tmp_path):
    refused("'--freq 9", "Invalid value for '--nextpnr': \"'--freq 9\": No closing quotation. Try ", calls, tmp_path)


@pytest.mark.parametrize("command", [REPORT, ["board"], ["soc"]], ids=lambda words: words[0])
def test_what_nextpnr_says_ends_a_command_at_once(command, calls, nextpnr, tmp_path):
    refused("--x", "--x: no such option\n", calls, tmp_path, command=command)


@pytest.mark.nightly
@pytest.mark.parametrize(("command", "options", "error"), [
    *((REPORT, *case) for case in REFUSED), (["board"], "--help", "refuses "), (["soc"], "--25k", "refuses ")])
def test_options_that_nextpnr_does_not_have_are_refused_at_once(command, options, error, calls, tmp_path):
    refused(options, error, calls, tmp_path, command=command)


@pytest.mark.nightly
def test_the_clock_of_a_soc_is_no_option_of_nextpnr(tmp_path):
    result = CliRunner().invoke(main, ["soc", "-o", str(tmp_path / "out"), "--nextpnr", "--freq 9"])
    assert (result.exit_code, result.output) == (2, "error: report: nextpnr-ecp5 refuses --freq 25 --freq 9: "
                                                    "option '--freq' cannot be specified more than once\n")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("clocks", "text"), [([99.6], "100"), ([120, 80], "80 / 100 / 120"), ([3, 1, 2], "1 / 2 / 3")])
def test_clocks_of_several_seeds(clocks, text):
    assert spread(clocks) == text


def test_another_family_has_its_cells_and_no_clock(tmp_path):
    command = ["report", "ctu", "--unit", "CellNumber", "--preset", "tiny", "--family", "gowin", "-o", str(tmp_path)]
    result = CliRunner().invoke(main, command)
    assert result.exit_code == 0, result.output
    assert result.output.splitlines()[-1] == "amaranth 0.5.10, pyosys 0.70; preset tiny."
    assert "# ctu: Gowin GW2A" in result.output
    assert "LUT: of 4 inputs, 1 for an adder's bit" in result.output
    assert "MHz" not in result.output
    assert (tmp_path / "ctu-gowin.md").read_text() in result.output
    assert not (tmp_path / "ctu-gowin" / "CellNumber" / "clock.json").exists()
    area = json.loads((tmp_path / "ctu-gowin" / "CellNumber" / "row.json").read_text())["area"]
    assert f"| CellNumber | 6 | {area['lut']} | {area['ff']} | {area['dsp']} | {area['bram']} |" in result.output
    refused = CliRunner().invoke(main, [*command, "--route"])
    assert (refused.exit_code, refused.output) == (2, "error: report: there is no place and route for Gowin GW2A\n")


@pytest.mark.nightly
def test_seeds_place_differently(tmp_path):
    row = measure("ctu", "CellNumber", CONFIG, tmp_path, seeds=(1, 2))
    assert len({clock.mhz for clock in row.clocks}) == 2
