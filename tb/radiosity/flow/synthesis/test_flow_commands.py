"""Words of commands for the tools, and what is read from their output; no tool runs."""

import json
import re
from contextlib import nullcontext
from types import SimpleNamespace

import pytest

from golden.base.errors import InputError
from radiosity.flow.synthesis import flow
from radiosity.flow.synthesis.family import FAMILIES
from radiosity.flow.synthesis.flow import Clock, bitstream, place_and_route, verilog_bitstream


def part(kind, delay, cell="", to=""):
    return {"type": kind, "delay": delay, "from": {"cell": cell}, "to": {"cell": to}}


PATHS = [
    {"from": "async", "to": "posedge clk", "path": [part("logic", 99.0, "pin", "pin")]},
    {"from": "posedge clk", "to": "async", "path": [part("logic", 98.0, "pin", "pin")]},
    {"from": "posedge clk", "to": "posedge clk", "path": [part("logic", 5.0, "short", "short")]},
    {"from": "posedge clk", "to": "posedge clk", "path": [
        part("clk-to-q", 0.5, "a.count_TRELLIS_FF_Q_3"), part("routing", 1.25), part("logic", 0.25),
        part("routing", 2.0), part("setup", 4.0, "x", "b.sum_LUT4_Z_1")]}]
REPORT = {"fmax": {"$glbnet$clk": {"achieved": 90.5, "constraint": 105.0},
                   "other": {"achieved": 71.25, "constraint": 105.0}}, "critical_paths": PATHS}
FASTEST = REPORT | {"fmax": {"$glbnet$clk": {"achieved": 91.5, "constraint": 105.0}}}
GRADE_8 = {"fmax": {"$glbnet$clk": {"achieved": 120.5}, "other": {"achieved": 95.0}}}

PLACED = {"modules": {"top": {"settings": {"timing/allowFail": "1", "target_freq": "25000000", "seed": "2",
                                           "router2/bbMargin/x": "8"}}}}
OPTIONS = {"seeds": (2, 4, 3), "options": ("--freq", "25")}


@pytest.fixture
def commands(monkeypatch, tmp_path):
    """The commands that are run, each with the name of its log."""
    found = []

    def run(command, log):
        found.append(([str(word) for word in command], log.name))
        if "--report" in command:
            report = GRADE_8 if "8" in command else FASTEST if "board.seed-4.placed.json" in command else REPORT
            (log.parent / command[command.index("--report") + 1]).write_text(json.dumps(report))
        if "--write" in command:
            (log.parent / command[command.index("--write") + 1]).write_text(json.dumps(PLACED))

    monkeypatch.setattr(flow, "_run", run)
    monkeypatch.setattr(flow, "_program", lambda name: f"/bin/{name}")
    return found


@pytest.mark.parametrize(("native", "version"), [("/bin/nextpnr", "nextpnr-1.2 (native)"), (None, "nextpnr-1.2")])
def test_a_native_nextpnr_is_marked(native, version, monkeypatch):
    monkeypatch.setattr(flow.shutil, "which", lambda name: native)
    monkeypatch.setattr(flow.subprocess, "run", lambda *_, **__: SimpleNamespace(
        stdout="", stderr="Next Generation Place and Route (Version nextpnr-1.2)"))
    assert flow.tool_versions().split(", ")[-1] == version


@pytest.mark.parametrize("option", ["--freq=90", "--freq"])
def test_a_target_clock_replaces_that_of_the_flow(option, commands, tmp_path):
    place_and_route(tmp_path / "clock.json", seed=7, options=(option,))
    assert "105" not in commands[0][0]


@pytest.mark.parametrize(("routability", "expected"), [
    ({}, {"router2/bbMargin/x": "8"}), ({"routability_driven": True}, flow._ROUTABILITY_DRIVEN)],
    ids=["timing", "routability"])
def test_a_netlist_is_placed_with_its_seed_and_then_routed(commands, tmp_path, routability, expected):
    """The clock is the slowest one, and may miss the target; its path the longest between registers, in two parts."""
    found = place_and_route(tmp_path / "clock.json", seed=7, options=("--router", "router2"), **routability)
    device = ["--85k", "--package", "CABGA381", "--speed", "6"]
    files = ["--lpf-allow-unconstrained", "--timing-allow-fail", "--freq", "105"]
    assert commands == [
        (["/bin/nextpnr-ecp5", "--json", "clock.json", *device, *files, "--router", "router2", "--seed", "7",
          "--no-route", "--write", "clock.seed-7.placed.json"], "clock.seed-7.placed.log"),
        (["/bin/nextpnr-ecp5", "--json", "clock.seed-7.placed.json", *device, *files, "--no-pack", "--no-place",
          "--report", "clock.seed-7.report.json", "--write", "clock.seed-7.routed.json"], "clock.seed-7.nextpnr.log"),
        (["/bin/nextpnr-ecp5", "--json", "clock.seed-7.grade-8.json", *device[:-1], "8", *files[:2], "--no-pack",
          "--no-place", "--report", "clock.seed-7.grade-8.report.json"], "clock.seed-7.grade-8.log")]
    routed = json.loads((tmp_path / "clock.seed-7.placed.json").read_text())["modules"]["top"]["settings"]
    assert routed == {"target_freq": "25000000", "seed": "2"} | expected
    analysed = json.loads((tmp_path / "clock.seed-7.grade-8.json").read_text())["modules"]["top"]["settings"]
    assert analysed == PLACED["modules"]["top"]["settings"] | {"arch.speed": "8", "router": "router1"}
    assert found == Clock(seed=7, mhz=71.25, path="4.8 + 3.2 ns, a.count to b.sum", mhz_grade_8=95.0)


def test_options_with_which_nothing_is_placed_are_named(monkeypatch, tmp_path):
    """A placement that an earlier run left is not routed in its place."""
    monkeypatch.setattr(flow, "_run", lambda command, log: None)
    (tmp_path / "clock.seed-7.placed.json").write_text(json.dumps(PLACED))
    with pytest.raises(InputError, match=r"report: nextpnr-ecp5 placed nothing with --help, see clock\.seed-7"):
        place_and_route(tmp_path / "clock.json", seed=7, options=("--help",))


@pytest.mark.parametrize(("make", "read", "router"), [
    (lambda folder: bitstream("text", "LOCATE", folder, "board", **OPTIONS), "read_rtlil board.il",
     {"router2/bbMargin/x": "8"}),
    (lambda folder: verilog_bitstream((folder / "a.v",), "LOCATE", folder, "board", **OPTIONS),
     'read_verilog -sv -defer "{}/a.v"', flow._ROUTABILITY_DRIVEN)], ids=["RTLIL", "Verilog"])
def test_a_bitstream_has_its_constraints_and_must_meet_its_clock(commands, monkeypatch, tmp_path, make, read, router):
    """An estimate may miss the clock, a route must not. Only the route of Verilog, a whole SoC, ignores timing. Of
    several seeds the fastest is packed.
    """
    area = FAMILIES["ecp5"].area({})
    monkeypatch.setattr(flow, "_area", lambda netlist, family: area)
    reads = []
    monkeypatch.setattr(flow, "_netlist", lambda read, folder, name, _: reads.extend(read) or folder / f"{name}.json")
    times = iter((10.0, 14.4, 20.0, 30.6, 31.0))
    monkeypatch.setattr(flow, "_processor_seconds", lambda: next(times))
    found = make(tmp_path)
    assert reads == [read.format(tmp_path)]
    assert found.area is area
    assert [(clock.seed, clock.mhz, clock.mhz_grade_8) for clock in found.clocks] == [
        (2, 71.25, None), (4, 91.5, None), (3, 71.25, None)]
    assert (found.synthesis_seconds, found.route_seconds) == (4, (6, 11, 0))
    assert (tmp_path / "board.lpf").read_text() == "LOCATE"
    (placing, _), (routing, routed), *_, (packing, packed) = commands
    assert len(commands) == 7
    assert placing[8:12] == routing[8:12] == ["--lpf", "board.lpf", "--textcfg", "board.seed-2.config"]
    assert placing[12:] == ["--freq", "25", "--seed", "2", "--timing-allow-fail", "--no-route", "--write",
                            "board.seed-2.placed.json"]
    assert routing[:3] == ["/bin/nextpnr-ecp5", "--json", "board.seed-2.placed.json"]
    assert routing[12:] == ["--no-pack", "--no-place", "--report", "board.seed-2.report.json", "--write",
                            "board.seed-2.routed.json"]
    assert packing == ["/bin/ecppack", "--compress", "board.seed-4.config", "board.bit"]
    assert (routed, packed) == ("board.seed-2.nextpnr.log", "board.ecppack.log")
    settings = json.loads((tmp_path / "board.seed-2.placed.json").read_text())["modules"]["top"]["settings"]
    assert settings == {"target_freq": "25000000", "seed": "2"} | router


def test_area_counts_cells_of_all_modules_but_black_boxes(tmp_path):
    def module(attributes, *cells):
        return {"attributes": attributes, "cells": {str(number): {"type": one} for number, one in enumerate(cells)}}

    netlist = tmp_path / "area.json"
    netlist.write_text(json.dumps({"modules": {
        "top": module({"folded_luts": f"{5:032b}"}, "LUT4", "LUT4", "TRELLIS_FF"),
        "part": module({"folded_luts": f"{2:032b}"}, "LUT4", "DP16KD", "MULT18X18D"),
        "LUT4": module({"blackbox": "1"}, "LUT4", "LUT4")}}))
    found = flow._area(netlist, FAMILIES["ecp5"])
    assert (found.lut, found.ff, found.bram, found.dsp, found.folded) == (3, 1, 1, 1, 7)


MEMORY = """module \\a
{attribute}  memory width 4 size 8 \\{memory}
  cell $memrd_v2 \\read
    parameter \\MEMID "\\\\m"
    parameter \\TRANSPARENCY_MASK 2'00
    parameter \\COLLISION_X_MASK 2'00
    parameter \\CLK_ENABLE {clocked}
  end
end
"""


UNCHECKED = "  attribute \\no_rw_check 1\n"


@pytest.mark.parametrize(("attribute", "memory", "clocked", "expected"), [
    (UNCHECKED, "m", 1, "11"), (f"{UNCHECKED}  attribute \\b 2\n", "m", 1, "11"), ("", "m", 1, "00"),
    (UNCHECKED, "n", 1, "00"), (UNCHECKED, "m", 0, "00")])
def test_clocked_read_ports_of_unchecked_memories_are_marked(attribute, memory, clocked, expected):
    text = MEMORY.format(attribute=attribute, memory=memory, clocked=clocked)
    found = flow._marked(text)
    assert re.search(r"COLLISION_X_MASK 2'(\d+)", found)[1] == expected
    assert re.search(r"TRANSPARENCY_MASK 2'(\d+)", found)[1] == "00"


@pytest.mark.parametrize(("printed", "last"), [
    ("first\nlast words\n\n", "last words"),
    # An error of nextpnr, with words behind it.
    ("ERROR: before routing\nERROR: 39 MHz (FAIL at 40 MHz)\nInfo: slack\n1 error\n",
     "ERROR: 39 MHz (FAIL at 40 MHz)")])
def test_a_tool_that_fails_is_a_line_with_its_last_words(monkeypatch, tmp_path, printed, last):
    def run(command, *, cwd, stdout, stderr, check):
        assert (cwd, check) == (tmp_path, False)
        stdout.write(printed)
        return SimpleNamespace(returncode=command[1:] == ["bad"])

    monkeypatch.setattr(flow.subprocess, "run", run)
    log = tmp_path / "a.log"
    flow._run(["/bin/tool", "good"], log)
    with pytest.raises(InputError) as error:
        flow._run(["/bin/tool", "bad"], log)
    assert str(error.value) == f"report: tool failed, see {log}: {last}"


@pytest.mark.parametrize(("returncode", "printed", "said"), [
    (1, "\nERROR: unrecognised option\n1 error\n", "unrecognised option"), (0, "\nusage\n--a\n", "usage"),
    (1, "Info: Program finished normally.\n", "Info: Program finished normally."),
    (0, "Info: Program finished normally.\n", None)])
def test_options_are_tried_without_a_netlist(monkeypatch, returncode, printed, said):
    """Refused with the first error, or the first line where it ends otherwise."""
    commands = []
    monkeypatch.setattr(flow.subprocess, "run", lambda command, **_: commands.append(command) or SimpleNamespace(
        returncode=returncode, stdout="", stderr=printed))
    with pytest.raises(InputError) if said else nullcontext() as error:
        flow.check_options(("--a", "1"))
    (command,) = commands
    assert "--json" not in command
    assert command[-3:] == ["--no-route", "--a", "1"]
    assert not said or str(error.value) == f"report: nextpnr-ecp5 refuses --a 1: {said}"
