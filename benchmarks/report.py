"""The command of a benchmark, and the page that it writes and prints: tables, and where they were measured."""

import platform
import re
from collections.abc import Callable, Sequence
from importlib.metadata import version
from pathlib import Path

import click

from golden.base.output import whole_file
from radiosity.charts.chart import Line, line_figure, write_figure
from radiosity.cli.console import console

__all__ = ["benchmark", "cell_text", "page_path", "provenance", "table", "tables_of", "versions", "write_chart",
           "write_report"]

_KEY = "benchmarks.page"


def benchmark(name: str, scenes: Sequence[str] = (), *, only: bool = False) -> Callable:
    """Make a function a benchmark's command, which has the option ``--output``.

    Parameters
    ----------
    name
        The page is out/bench/NAME.md by default.
    scenes
        Values of the argument ``scenes`` unless others are given. Default: there is no such argument.
    only
        Other scenes than these are refused.
    """
    def remember(ctx, param, value):
        ctx.meta[_KEY] = value

    output = click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path), expose_value=False,
                          default=f"out/bench/{name}.md", callback=remember, help="Write the page to this file.")
    argument = click.argument("scenes", nargs=-1, type=click.Choice(list(scenes)) if only else None,
                              metavar="[SCENES]...", callback=lambda ctx, param, value: value or tuple(scenes))
    return lambda function: click.command()(argument(output(function)) if scenes else output(function))


def page_path() -> Path:
    """The page of the command that runs."""
    return click.get_current_context().meta[_KEY]


def cell_text(cell: float | None) -> str:
    """A cell size, or None: each scene's is chosen."""
    return "chosen cells" if cell is None else f"cell {cell:g}"


def provenance(*packages: str) -> str:
    """The machine, and the versions of Python and of packages."""
    return ", ".join([platform.machine(), *(f"{name} {text}" for name, text in versions(*packages).items())])


def versions(*packages: str) -> dict[str, str]:
    """Those of Python and of packages."""
    return {"Python": platform.python_version(), **{name: version(name) for name in packages}}


def table(head: Sequence[str], rows: Sequence[Sequence]) -> list[str]:
    """Lines of a Markdown table.

    Raises
    ------
    ValueError
        Two columns have one name: `tables_of` finds cells by it.
    """
    if len({*head}) < len(head):
        raise ValueError(f"Columns of a table must have names of their own, not {head!r}")
    return [_line(head), "|---" * len(head) + "|", *map(_line, rows)]


def tables_of(lines: list[str]) -> list[dict]:
    """The tables of a page: title of the section, and of each row its cells by column; numbers are numbers."""
    found, title, head = [], "", None
    for line in "\n".join(lines).splitlines():
        if line.startswith("#"):
            title, head = line.lstrip("# "), None
        elif not line.startswith("|"):
            head = None
        elif head is None:
            head = _cells(line)
            found.append({"title": title, "rows": []})
        elif not re.fullmatch(r"(\|\s*:?-{3,}:?\s*)+\|", line):
            found[-1]["rows"].append(dict(zip(head, map(_value, _cells(line)), strict=False)))
    return found


def write_report(title: str, *parts: str | list[str], report: dict | None = None) -> None:
    """Write the page of the command that runs, and print it or, with ``--json``, the report.

    Parameters
    ----------
    title, parts
        The page's title, and what stands below it with an empty line between: paragraphs, and lines of tables.
    report
        Default: the tables.
    """
    path, lines = page_path(), [f"# {title}"]
    for part in parts:
        lines += ["", *([part] if isinstance(part, str) else part)]
    text = "\n".join(lines).rstrip()
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole_file(path) as written:
        written.write_text(text + "\n")
    report = {"file": str(path), "tables": tables_of(lines)} if report is None else report
    console().report(report, f"{text}\n\nwrote {path}")


def write_chart(name: str, lines: list[Line], **texts) -> None:
    """Write a chart with a name beside the page; ``texts`` are those of `line_figure`."""
    write_figure(page_path().with_name(f"{name}.svg"), line_figure(lines, **texts))


def _line(cells):
    return "| " + " | ".join(map(str, cells)) + " |"


def _cells(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def _value(cell):
    for kind in int, float:
        try:
            return kind(cell)
        except ValueError:
            continue
    return cell
