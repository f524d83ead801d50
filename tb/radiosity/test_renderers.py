"""Both command lines render, each by its own default."""

import json
import re

import pytest
from click.testing import CliRunner

import radiosity.cli.golden.main
import radiosity.cli.main


@pytest.mark.parametrize(("main", "method"), [(radiosity.cli.golden.main.main, "shelling"), (radiosity.cli.main.main,
                                                                                             "embree")],
                         ids=["golden", "radiosity"])
def test_the_golden_model_renders_by_shelling_and_says_first_how_long(main, method, tmp_path):
    """Nodes are the corners of six squares, each with its own; of six elements adaptive refinement cuts none."""
    result = CliRunner().invoke(main, ["render", "furnace:1", "-o", str(tmp_path / "a.png"), "--size", "2x2",
                                       "--max-edge", "9", "--rays", "16x4", "--json"])
    assert result.exit_code == 0, result.stderr
    assert json.loads(result.stdout)["settings"]["method"] == method
    announced = re.fullmatch(r"shelling: 24 hemispheres at most, about \d+ s; then the picture\n", result.stderr)
    assert (announced is not None) == (method == "shelling")
    assert (result.stderr == "") == (method == "embree")
