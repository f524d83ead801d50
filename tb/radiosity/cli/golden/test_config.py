import json

import pytest
from click.testing import CliRunner

from golden.engine.config import PRESETS
from radiosity.cli.golden.main import main


def run(*arguments):
    return CliRunner().invoke(main, ["config", *arguments])


@pytest.mark.parametrize("preset", PRESETS)
def test_json_holds_every_parameter_and_the_widths(preset):
    shown = json.loads(run(preset, "--json").stdout)
    assert shown["preset"] == preset
    assert shown["parameters"] == PRESETS[preset].parameters()
    fraction = PRESETS[preset].numbers.vector_fraction
    assert shown["derived"]["numbers.vector"]["format"] == f"signed 1.{fraction}"
    assert shown["derived"]["numbers.vector"]["bits"] == 2 + fraction


def test_parameters_change_what_is_derived():
    shown = json.loads(run("tiny", "-P", "icu.uv_bits=6", "-P", "icu.rays=0x80", "--json").stdout)
    assert (shown["parameters"]["icu.uv_bits"], shown["parameters"]["icu.rays"]) == (6, 128)
    assert shown["derived"]["icu.uv"] == {**shown["derived"]["icu.uv"], "format": "unsigned 0.6", "bits": 6}


def test_the_table_has_a_line_with_a_text_for_each_parameter_and_marks_the_changed():
    shown = run("tiny", "-P", "icu.rays=128").stdout.splitlines()
    lines = {line.split()[0]: line.split()[1:] for line in shown if line}
    assert set(PRESETS["tiny"].parameters()) <= set(lines)
    assert lines["icu.rays"][0] == "128*"
    assert all(len(lines[path]) > 3 for path in PRESETS["tiny"].parameters())


@pytest.mark.parametrize(("arguments", "says"), [
    (("huge",), "'huge' is not one of"), ((), "Missing argument"),
    (("tiny", "-P", "icu.rays=3"), "Rays (icu.rays) must be 64 to 4194304, not 3"),
    (("tiny", "-P", "rays=64"), "there is no parameter 'rays'")])
def test_bad_input_is_one_line(arguments, says):
    result = run(*arguments)
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert result.stderr.startswith("error: ")
    assert says in result.stderr
