"""A fixed set of units has the area and the Fmax that are recorded: neither more nor less."""

from dataclasses import replace

import pytest
from click.testing import CliRunner

import radiosity.flow.synthesis.figures
from golden.engine.config import PRESETS
from radiosity.cli.hw.main import main
from radiosity.flow.synthesis import flow
from radiosity.flow.synthesis.figures import pages, with_tables
from radiosity.flow.synthesis.history import Commit, Record, last_records, read_history
from radiosity.flow.synthesis.report import measure

PRESET = "small"
# The tolerance of each figure, as a share of the recorded one. `python -m hw report ... --record` records an intended
# difference.
SHARE = {"LUT": 0.02, "FF": 0.02, "DSP": 0, "block RAM": 0, "MHz": 0.05}
# By family, block and unit: whether Fmax is compared too, of the first seed that was recorded.
RATCHET = {
    ("ecp5", "icu", "RayDirection"): True, ("ecp5", "ctu", "CellNumber"): True, ("ecp5", "icu", "SettleMap"): False,
    ("ecp5", "memsys", "CellTable"): False, ("ecp5", "noc", "Router-32-1"): False,
    ("gowin", "icu", "RayDirection"): False,
}


def departures(found, last):
    """Figures that are not what was recorded, in words; clocks of seeds that both have."""
    pairs = {"LUT": (found.lut, last.lut), "FF": (found.ff, last.ff), "DSP": (found.dsp, last.dsp),
             "block RAM": (found.bram, last.bram)}
    before = dict(zip(last.seeds, last.mhz, strict=True))
    pairs |= {f"MHz of seed {seed}": (mhz, before[seed]) for seed, mhz in zip(found.seeds, found.mhz, strict=True)}
    return [f"{name} {now} instead of {then}" for name, (now, then) in pairs.items()
            if abs(now - then) > SHARE[name.split(" of ")[0]] * then]


@pytest.mark.nightly
@pytest.mark.parametrize(("family", "block", "unit"), [pytest.param(*one, id="-".join(one)) for one in RATCHET])
def test_area_and_clock_stay(family, block, unit, tmp_path, monkeypatch):
    # The packaged tool: placements of an installed one differ.
    monkeypatch.setattr(flow.shutil, "which", lambda name: None)
    last = last_records(read_history())[family, PRESET, "", block, unit]
    seeds = last.seeds[:RATCHET[family, block, unit]]
    row = measure(block, unit, PRESETS[PRESET], tmp_path, family=family, seeds=seeds,
                  options=tuple(last.options.split()), routability_driven=last.routing == "routability-driven")
    found = Record.of(row, Commit(name="", date=""), tools="", family=family, preset=PRESET, parameters="", block=block,
                      options=last.options, routing=last.routing)
    again = "".join(f" --seed {seed}" for seed in last.seeds)
    assert not (differ := departures(found, last)), (
        f"{unit}: {', '.join(differ)}; if that is meant: python -m hw report {block} --unit {unit} --preset {PRESET} "
        f"--family {family}{again} --record")


BEFORE = Record(commit="a", date="2026-11-21", tools="", family="ecp5", preset=PRESET, parameters="", block="icu",
                unit="Unit", latency=None, lut=1000, ff=500, dsp=2, bram=4, options="", routing="timing-driven",
                seeds=(1, 2), mhz=(100.0, 120.0), mhz_grade_8=(130.0, 150.0))


@pytest.mark.parametrize(("change", "fails"), [
    ({}, []), ({"lut": 1020, "ff": 490, "mhz": (95.0, 126.0)}, []),
    ({"lut": 1021}, ["LUT 1021 instead of 1000"]), ({"lut": 979}, ["LUT 979 instead of 1000"]),
    ({"ff": 511}, ["FF 511 instead of 500"]), ({"ff": 489}, ["FF 489 instead of 500"]),
    ({"dsp": 3}, ["DSP 3 instead of 2"]), ({"dsp": 1}, ["DSP 1 instead of 2"]),
    ({"bram": 5}, ["block RAM 5 instead of 4"]), ({"bram": 3}, ["block RAM 3 instead of 4"]),
    ({"mhz": (94.9, 120.0)}, ["MHz of seed 1 94.9 instead of 100.0"]),
    ({"mhz": (100.0, 126.1)}, ["MHz of seed 2 126.1 instead of 120.0"]),
    ({"seeds": (2,), "mhz": (113.9,)}, ["MHz of seed 2 113.9 instead of 120.0"]), ({"seeds": (), "mhz": ()}, [])])
def test_a_figure_that_is_worse_or_better_fails(change, fails):
    assert departures(replace(BEFORE, **change), BEFORE) == fails


def test_all_of_the_set_has_been_recorded():
    last = last_records(read_history())
    for (family, block, unit), has_clock in RATCHET.items():
        assert bool(last[family, PRESET, "", block, unit].mhz) >= has_clock


def test_tables_are_what_the_command_writes():
    history = read_history()
    assert pages()
    for page in pages():
        assert page.read_text() == with_tables(page.read_text(), history), "python -m hw figures"


def test_a_table_has_the_last_figures_of_its_units():
    marked = "before\n<!-- area: icu -->\nold\n<!-- area: end -->\nafter\n"
    unit = replace(BEFORE, unit="Sbb", latency=9, options="--router router2")
    text = with_tables(marked, [unit, replace(unit, commit="b", lut=7, seeds=(1, 2, 3), mhz=(90.0, 130.0, 99.5)),
                               replace(unit, unit="Ipbb", family="xc7"), replace(unit, preset="paper", lut=8)])
    assert text.startswith("before\n<!-- area: icu -->\n\n| unit | latency | LUT | FF | DSP | block RAM | MHz |")
    assert "\n| `Sbb` | 9 | 7 | 500 | 2 | 4 | 90 / 100 / 130 | 1, 2, 3 | b |\n\nECP5-85" in text
    assert 'Other options of nextpnr: `Sbb` with `--nextpnr "--router router2"`.' in " ".join(text.split())
    routed = with_tables(marked, [replace(unit, options=" ".join(flow.OPTIONS), routing="routability-driven")])
    assert "`Sbb` with `--nextpnr \"--placer-heap-timingweight 30\" --routability-driven`." in " ".join(routed.split())
    assert text.endswith("\n\n<!-- area: end -->\nafter\n")
    assert text.count("| `") == 1
    named = marked.replace("icu", "icu Ipbb Sbb")
    two = with_tables(named, [unit, *(replace(unit, unit=name) for name in ("Ipbb", "EdgePlanes"))])
    assert [line.split(" | ")[0] for line in two.splitlines() if line.startswith("| `")] == ["| `Ipbb`", "| `Sbb`"]
    empty = marked.replace("old", "\nNothing has been recorded yet.\n")
    assert with_tables(text, []) == with_tables(empty, []) == empty


def test_units_that_were_not_routed_are_named_so():
    unit = replace(BEFORE, unit="Sbb")
    for records, count in ([unit], 0), ([unit, replace(unit, unit="Ipbb", seeds=(), mhz=())], 1):
        text = with_tables("<!-- area: icu -->\n<!-- area: end -->\n", records)
        assert " ".join(text.split()).count("Without MHz: synthesised, not routed.") == count


def test_a_tool_is_named_once():
    unit = replace(BEFORE, unit="Sbb", tools="amaranth 1, nextpnr-1")
    records = [unit, replace(unit, unit="Ipbb", tools="amaranth 1, nextpnr-2")]
    text = with_tables("<!-- area: icu -->\n<!-- area: end -->\n", records)
    assert "\namaranth 1, nextpnr-1, nextpnr-2." in text.replace(" amaranth", "\namaranth")


def test_a_unit_of_other_families_is_beside_its_own():
    unit = replace(BEFORE, unit="Sbb")
    records = [replace(unit, family="ice40", lut=3), replace(unit, family="xc7", lut=2), unit,
               replace(unit, unit="Ipbb")]
    text = with_tables("<!-- area: families -->\n<!-- area: end -->\n", records)
    assert [line.split(" | ")[1:3] for line in text.splitlines() if line.startswith("| `")] == [
        ["ECP5-85, speed grade 6", "1000"], ["Xilinx 7 series", "2"], ["iCE40 UltraPlus", "3"]]
    assert text.count("* ") == 3


def test_a_machine_that_is_routed_has_the_median_of_its_seeds():
    """In its table, of which the shares are of an ECP5-85, and in sentences."""
    machine = replace(BEFORE, preset="board", parameters="", block="board", unit="BoardShell",
                      lut=41_820, ff=8364, dsp=39, bram=52, seeds=(1, 2, 3, 4), mhz=(53.1, 50.0, 54.1, 51.1))
    marked = "<!-- area: machine -->\n<!-- area: end -->\nat <!-- routed -->old<!-- routed: end --> here\n"
    text = with_tables(marked, [machine, replace(machine, parameters="noc.columns=2", mhz=(1.0,), seeds=(1,))])
    assert "\n| `BoardShell` | 41,820 (50 %) | 8,364 (10 %) | 39 (25 %) | 52 (25 %) | 50.0 / 52.1 / 54.1 |" in text
    assert text.endswith("at <!-- routed -->52.1 MHz (median of seeds 1, 2, 3, 4)<!-- routed: end --> here\n")
    assert with_tables(text, [replace(machine, seeds=(1,), mhz=(53.1,))]).endswith(
        "at <!-- routed -->53.1 MHz (seed 1)<!-- routed: end --> here\n")
    assert "an unknown clock" in with_tables(text, [])


def test_the_command_writes_what_has_changed(tmp_path, monkeypatch):
    page = tmp_path / "README.md"
    page.write_text("<!-- area: main -->\n<!-- area: end -->\n")
    monkeypatch.setattr(radiosity.flow.synthesis.figures, "pages", lambda: [page])
    for expected in (f"{page}\n", ""):
        assert CliRunner().invoke(main, ["figures"]).output == expected
