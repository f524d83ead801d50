import csv

import numpy as np
import pytest

from golden.light.factors.exchange import net_exchange
from golden.light.factors.files import write_view_factors
from golden.light.factors.view_factors import ViewFactors
from tb.golden.light.factors.samples import three_sides
from tb.radiosity.cli.golden.runner import report, run

# W/(m2 K4).
STEFAN_BOLTZMANN = 5.670374419e-8


def rows(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def heat_of(path):
    """Net heat in W of all patches of a table."""
    return sum(float(row["area"]) * float(row["flux"]) for row in rows(path))


@pytest.fixture
def factors(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    factors = three_sides(surface=np.array(["sun", "wall", "wall"]))
    write_view_factors(factors, tmp_path / "F.nc")
    return factors


def test_surfaces_of_a_table_are_those_of_patches(factors, tmp_path):
    (tmp_path / "t.csv").write_text("surface, emissivity, temperature, flux\nwall,0.5,,0\nsun,0.9,600,\n")
    printed = report("exchange", "F.nc", "t.csv", "-o", "q.csv", "--sky-temperature", "250", "--script-f", "s.csv")
    expected = net_exchange(factors, temperature=(600, np.nan, np.nan), emissivity=(0.9, 0.5, 0.5),
                            flux=(np.nan, 0, 0), sky_temperature=250)
    written = rows(tmp_path / "q.csv")
    assert [row["surface"] for row in written] == ["sun", "wall", "wall"]
    for name in "temperature", "radiosity", "irradiance", "flux":
        np.testing.assert_array_equal([float(row[name]) for row in written], getattr(expected, name))
    heat = factors.area * expected.flux
    assert [row["heat"] for row in printed["surfaces"]] == pytest.approx([heat[0], 0])
    assert printed["heat_to_sky"] == pytest.approx(heat.sum())
    shares = rows(tmp_path / "s.csv")
    assert [row["surface"] for row in shares] == ["sun", "wall"]
    # The rest of the sun's emissivity leaves for the sky.
    assert 0.75 < float(shares[0]["sun"]) + float(shares[0]["wall"]) < 0.9


def test_a_table_may_list_patches(factors, tmp_path):
    (tmp_path / "t.csv").write_text("patch,temperature,emissivity\n2,500,0.1\n0,300,0.9\n1,400,0.5\n")
    text = run("exchange", "F.nc", "t.csv", "-o", "q.csv", "--sky-temperature", "265.5").stdout
    assert [float(row["temperature"]) for row in rows(tmp_path / "q.csv")] == [300, 400, 500]
    assert text.splitlines()[-1].split()[:5] == ["sky", "of", "265.5", "K", f"{heat_of(tmp_path / 'q.csv'):.6g}"]


@pytest.mark.parametrize("word", ["warm", "3_00"])
def test_a_wrong_line_of_a_table_is_named_as_an_editor_numbers_it(factors, tmp_path, word):
    (tmp_path / "t.csv").write_text(f"surface,temperature,emissivity\nsun,600,0.9\nwall,{word},0.5\n")
    result = run("exchange", "F.nc", "t.csv", "-o", "q.csv")
    assert result.exit_code
    assert f"t.csv: line 3: Temperature must be a number, not '{word}'" in result.stderr


def test_a_table_of_a_spreadsheet_is_read(tmp_path, monkeypatch):
    """Such programs begin UTF-8 with a byte order mark; blanks around names do not count, in the scene neither."""
    monkeypatch.chdir(tmp_path)
    write_view_factors(three_sides(surface=np.array([" sun", "wall", ""])), tmp_path / "F.nc")
    (tmp_path / "t.csv").write_text("surface ,temperature,emissivity\nsun,600,0.9\n wall ,300,0.5\n,400,0.5\n",
                                    encoding="utf-8-sig")
    report("exchange", "F.nc", "t.csv", "-o", "q.csv")
    assert [float(row["temperature"]) for row in rows(tmp_path / "q.csv")] == [600, 300, 400]


@pytest.mark.parametrize(("words", "message"), [
    (("-o", "t.csv"), "'t.csv': it is the input"), (("-o", "q.csv", "--script-f", "t.csv"), "'t.csv': it is the input"),
    (("-o", "q.csv", "--script-f", "q.csv"), "'q.csv': it is named twice"),
    (("-o", "q.csv"), "there is no row for patch '1' and 1 more")])
def test_nothing_is_written_over_or_from_a_part_of_a_table(factors, tmp_path, words, message):
    table = "patch,temperature,emissivity\n0,300,0.9\n"
    (tmp_path / "t.csv").write_text(table)
    result = run("exchange", "F.nc", "t.csv", *words)
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert result.stderr.endswith(f"{message}\n")
    assert {path.name for path in tmp_path.iterdir()} == {"F.nc", "t.csv"}
    assert (tmp_path / "t.csv").read_text() == table


@pytest.mark.parametrize("header", ["patch,temperature,emissivity,emissivity", "patch,emissivity",
                                    "patch,temperature,emissivity,colour"])
def test_a_header_must_have_every_name_once(factors, tmp_path, header):
    (tmp_path / "t.csv").write_text(f"{header}\n")
    result = run("exchange", "F.nc", "t.csv", "-o", "q.csv")
    assert result.exit_code == 2
    assert f"each once, not {header.replace(',', ', ')}\n" in result.stderr


def test_a_facet_alone_loses_what_it_emits(tmp_path, monkeypatch):
    """Its row of view factors is empty, and a square foot is 0.3048^2 m2."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.obj").write_text("v 0 0 0\nv 2 0 0\nv 0 2 0\nf 1 2 3\n")
    (tmp_path / "t.csv").write_text("patch,temperature,emissivity\n0,400,0.5\n")
    made = report("formfactors", "a.obj", "--facets", "--unit", "ft", "--rays", "16x4", "-o", "F.npz")
    assert (made["patches"], made["entries"]) == (1, 0)
    printed = report("exchange", "F.npz", "t.csv", "-o", "q.csv", "--sky-temperature", "300", "--script-f", "s.csv")
    flux = 0.5 * STEFAN_BOLTZMANN * (400**4 - 300**4)
    (row,) = rows(tmp_path / "q.csv")
    assert float(row["flux"]) == pytest.approx(flux, rel=1e-12)
    assert printed["heat_to_sky"] == pytest.approx(2 * 0.3048**2 * flux, rel=1e-12)
    assert [[*row.values()] for row in rows(tmp_path / "s.csv")] == [["unspecified", "0.0"]]


@pytest.mark.parametrize("ending", ["npz", "nc"])
def test_a_hot_wall_of_a_black_box_heats_the_others(tmp_path, monkeypatch, ending):
    """All that it emits arrives there, whatever the single view factors are; a square millimetre is 1e-6 m2."""
    monkeypatch.chdir(tmp_path)
    factors = f"F.{ending}"
    report("formfactors", "furnace:2", "--rays", "32x8", "--samples", "2", "--project", "--unit", "mm", "-o", factors)
    hot = ViewFactors.open(tmp_path / factors).normal[:, 2] > 0.5
    assert hot.sum() == 4
    (tmp_path / "t.csv").write_text("patch,emissivity,temperature\n" + "".join(
        f"{patch},1,{500 if is_hot else 300}\n" for patch, is_hot in enumerate(hot)))
    printed = report("exchange", factors, "t.csv", "-o", "q.csv")
    heat = np.array([float(row["flux"]) for row in rows(tmp_path / "q.csv")]) * 0.25e-6
    expected = 1e-6 * STEFAN_BOLTZMANN * (500**4 - 300**4)
    assert heat[hot].sum() == pytest.approx(expected, rel=1e-9)
    assert heat[~hot].sum() == pytest.approx(-expected, rel=1e-9)
    # The four patches of the wall are alike, and so are the opposite ones.
    assert np.ptp(heat[hot]) < 0.1 * heat[hot].mean()
    assert printed["heat_to_sky"] == pytest.approx(0, abs=1e-12 * expected)
