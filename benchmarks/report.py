"""The page that a benchmark writes and prints: tables, and where they were measured."""

import platform
import re
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import click

from golden.base.output import whole_file
from radiosity.cli.console import console

__all__ = ["cell_text", "output_option", "provenance", "table", "tables_of", "versions", "write_report"]


def output_option(name: str) -> Callable:
    """The option ``--output`` of the benchmark ``name``."""
    return click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path),
                        default=f"out/bench/{name}.md", help="Write the page to this file.")


def cell_text(cell: float | None) -> str:
    """A cell size, or None: each scene's is chosen."""
    return "chosen cells" if cell is None else f"cell {cell:g}"


def provenance(*packages: str) -> str:
    """The machine, and the versions of Python and of packages."""
    return ", ".join([platform.machine(), *(f"{name} {text}" for name, text in versions(*packages).items())])


def versions(*packages: str) -> dict[str, str]:
    """Those of Python and of packages."""
    return {"Python": platform.python_version(), **{name: version(name) for name in packages}}


def table(head: list[str], rows: list[list]) -> list[str]:
    """Lines of a Markdown table."""
    return ["| " + " | ".join(head) + " |", "|---" * len(head) + "|",
            *("| " + " | ".join(map(str, row)) + " |" for row in rows)]


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


def write_report(path: Path, lines: list[str], *, report: dict | None = None) -> None:
    """Write a page, and print it or, with ``--json``, the report; by default its tables."""
    path.parent.mkdir(parents=True, exist_ok=True)
    text = "\n".join(lines)
    with whole_file(path) as part:
        part.write_text(text.rstrip() + "\n")
    report = {"file": str(path), "tables": tables_of(lines)} if report is None else report
    console().report(report, f"{text.rstrip()}\n\nwrote {path}")


def _cells(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def _value(cell):
    for kind in int, float:
        try:
            return kind(cell)
        except ValueError:
            continue
    return cell
