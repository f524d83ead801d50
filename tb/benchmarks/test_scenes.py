"""Scenes that a benchmark has nothing to compare with, and options that need others."""

import json

import pytest
from click.testing import CliRunner

import radiosity.cli.main


@pytest.mark.parametrize(("arguments", "message"), [
    (("thesis_networks", "man"), "'man' is not one of 'lobby', 'room1627'"),
    (("machines", "--calibrate", "lobby", "phone"),
     "Scenes must be of cornell, lobby, room1627, tetra, man, cubes with --calibrate, not 'phone'"),
    (("istructure", "--calibrate", "lobby", "phone"),
     "Scenes must be of lobby, room1627, cubes with --calibrate, not 'phone'"),
    (("istructure", "--calibrate", "--clusters", "4"), "--clusters does not go with --calibrate"),
    (("istructure", "--calibrate", "--sizes"), "--sizes does not go with --calibrate"),
    (("istructure", "--hardware", "lobby"), "--hardware needs --calibrate"),
    (("throughput", "--source", "a board"), "--source needs --mhz")])
def test_what_would_be_ignored_is_refused(tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(radiosity.cli.main.main, ["bench", *arguments])
    assert result.exit_code == 2
    assert result.stderr.startswith("error: ")
    assert message in result.stderr
    assert result.stderr.count("\n") == 1
    assert not any(tmp_path.iterdir())


def test_recorded_rows_are_those_of_the_scenes(tmp_path, monkeypatch):
    monkeypatch.setattr("benchmarks.istructure.simulated_rows", lambda rows: ((row, row.cycles) for row in rows))
    for scenes in (), ("cubes",), ("lobby", "cubes"):
        result = CliRunner().invoke(radiosity.cli.main.main, [
            "bench", "istructure", *scenes, "--calibrate", "--json", "-o", str(tmp_path / "x.md")])
        table, = json.loads(result.stdout)["tables"]
        assert {row["scene"].strip("`") for row in table["rows"]} == set(scenes or ("lobby", "room1627", "cubes"))
