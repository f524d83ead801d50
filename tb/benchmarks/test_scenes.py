"""Scenes that a benchmark has nothing to compare with."""

import pytest
from click.testing import CliRunner

import radiosity.cli.main


@pytest.mark.parametrize(("arguments", "message"), [
    (("thesis_networks", "man"), "'man' is not one of 'lobby', 'room1627'"),
    (("machines", "--calibrate", "lobby", "phone"),
     "Scenes must be of cornell, lobby, room1627, tetra, man, cubes with --calibrate, not 'phone'")])
def test_a_scene_without_a_reference_is_refused(tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(radiosity.cli.main.main, ["bench", *arguments])
    assert result.exit_code == 2
    assert result.stderr.startswith("error: ")
    assert message in result.stderr
    assert result.stderr.count("\n") == 1
    assert not any(tmp_path.iterdir())
