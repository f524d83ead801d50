"""Pages of benchmarks: tables in Markdown, and the same as JSON."""

import ast
import json
from pathlib import Path

import click
import pytest
from click.testing import CliRunner

import benchmarks
from benchmarks import main_memory
from benchmarks.main_memory import BURST_BEATS, bound, rate
from benchmarks.report import benchmark, table, tables_of, write_report
from radiosity.cli.bench import bench
from radiosity.cli.main import main as radiosity

PARTS = ("Words.", "## First", table(["scene", "count"], [["man", 3], ["lobby", 0.25]]),
         ["## Second", "| a |", "|---|", "| - |"])
LINES = ["# A page", "", "Words.", "", "## First", "", *PARTS[2], "", *PARTS[3]]


def test_tables_of_a_page():
    assert tables_of(LINES) == [
        {"title": "First", "rows": [{"scene": "man", "count": 3}, {"scene": "lobby", "count": 0.25}]},
        {"title": "Second", "rows": [{"a": "-"}]}]


def test_columns_of_one_name_are_refused():
    with pytest.raises(ValueError, match="must have names of their own"):
        table(["scene", "grade", "grade"], [])


def test_columns_of_the_benchmarks_have_names_of_their_own():
    """Those of the heads that are written out."""
    heads = 0
    for path in sorted(Path(benchmarks.__file__).parent.glob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "table" and isinstance(
                    node.args[0], ast.List):
                names = [name for one in node.args[0].elts for name in _names(one)]
                assert len({*names}) == len(names), f"{path.name}:{node.lineno}: {names}"
                heads += 1
    assert heads > 40


def _names(column):
    """The constants of a column, or of those that a comprehension makes again and again."""
    if isinstance(column, ast.Constant):
        return [column.value]
    if isinstance(column, ast.Starred):
        # A constant of an element is repeated.
        return [node.value for part in ast.walk(column) if isinstance(part, ast.GeneratorExp)
                for node in getattr(part.elt, "elts", [part.elt]) if isinstance(node, ast.Constant) for _ in range(2)]
    return []


def test_the_page_is_written_and_printed(tmp_path):
    @benchmark("x")
    def command():
        write_report("A page", *PARTS)

    path = tmp_path / "new" / "x.md"
    result = CliRunner().invoke(command, ["-o", str(path)], catch_exceptions=False)
    assert path.read_text() == "\n".join(LINES) + "\n"
    assert result.stdout == f"{path.read_text()}\nwrote {path}\n"


def test_json_is_one_object(tmp_path, monkeypatch):
    monkeypatch.setattr(main_memory, "rate", lambda outstanding, latency: 0.5)
    result = CliRunner().invoke(radiosity, ["bench", "main_memory", "--json", "-o", str(tmp_path / "x.md")])
    tables = json.loads(result.stdout)["tables"]
    assert [one["title"] for one in tables] == ["Measured", "Bound"]
    assert tables[0]["rows"][0] | {"1 cycles": 0.5} == tables[0]["rows"][0]


@pytest.mark.parametrize("name", bench.list_commands(click.Context(bench)))
def test_help_is_a_sentence(name):
    command = bench.get_command(click.Context(bench), name)
    about = " ".join(command.help.split())
    assert about[0].isupper()
    assert about.endswith(".")
    for parameter in command.params:
        if isinstance(parameter, click.Option):
            assert parameter.help, f"{name}: {parameter.name}"


@pytest.mark.parametrize(("outstanding", "latency"), [(1, 1), (2, 20), (4, 5)])
def test_the_memory_port_reaches_its_bound(outstanding, latency):
    assert rate(outstanding, latency, beats=16 * BURST_BEATS) == pytest.approx(bound(outstanding, latency), abs=0.03)
