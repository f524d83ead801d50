"""The commands that pages show, and the figures that they quote.

A command stands in a block marked ``sh``, or in a code span that begins with a program of `PROGRAMS`. A comment
``<!-- prints: TEXT -->`` on a page says that the last command before it prints TEXT; a comment
``<!-- not run: WHY -->`` that it, or its block, is not run. ``<!-- table: COMMAND -->`` stands before a table, or after
a link to a file of docs/data/, of which each row has figures of one row that the command prints.
"""

import csv
import re
import shlex
from dataclasses import dataclass, field
from pathlib import Path

from tb.docs.language import ROOT

__all__ = ["PROGRAMS", "TABLE", "Command", "commands_of", "files_of", "missing_rows", "pages", "tables_of"]

# A table of a page with the command that prints its rows.
TABLE = re.compile(r"<!-- table: (.*?) -->\n\n((?:\|.*\n)+)")
PROGRAMS = ("radiosity", "make", "pytest", "python -m")

_PART = re.compile(r"^ *```(?P<language>\w*)\n(?P<block>.*?)^ *```|(?<!`)`(?P<span>[^`]+)`(?!`)"
                   r"|<!-- prints: (?P<prints>.*?) -->|<!-- not run: (?P<why>.*?) -->", re.MULTILINE | re.DOTALL)
# A word that stands for another one: SCENE, DIR, FILE.png, ..., a|b.
_PLACEHOLDER = re.compile(r"(?:^|[=/])(?:[A-Z]{2,}[A-Z_]*|DIR|N)(?:\.\w+)?$|\.\.\.|\|")


@dataclass
class Command:
    """A command of a page."""

    page: Path
    line: int
    words: tuple[str, ...]
    prints: list[str] = field(default_factory=list)
    not_run: str | None = None

    def __str__(self):
        return f"{self.page.name}:{self.line}: {shlex.join(self.words)}"

    @property
    def is_complete(self) -> bool:
        """Whether it can be given as it stands: nothing in it stands for something else."""
        return not any(_PLACEHOLDER.search(word) for word in self.words)


def pages() -> list[Path]:
    """README, CONTRIBUTING and docs/ without what is made from code: docs/formats/."""
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]


def commands_of(page: Path, text: str | None = None) -> list[Command]:
    """All commands of a page in their order."""
    text = page.read_text() if text is None else text
    found, last = [], []
    for part in _PART.finditer(text):
        line = text.count("\n", 0, part.start()) + 1
        if part["block"] is not None:
            if part["language"] in ("sh", "console"):
                last = [Command(page, line, words) for words in _lines(part["block"])]
                found += last
        elif part["span"] is not None:
            words = " ".join(part["span"].split())
            if words.startswith(tuple(f"{program} " for program in PROGRAMS)):
                last = [Command(page, line, tuple(shlex.split(words)))]
                found += last
        elif part["prints"]:
            assert last, f"{page.name}:{line}: no command before it prints {part['prints']!r}"
            last[-1].prints.append(part["prints"])
        else:
            behind = text[part.end():].lstrip()
            assert not behind.startswith(("```sh", "```console")), f"{page.name}:{line}: put it behind the block"
            for command in last:
                command.not_run = part["why"]
    return found


def _lines(block):
    for line in re.sub(r"\\\n\s*", "", block).splitlines():
        if words := tuple(shlex.split(line, comments=True)):
            yield words


def tables_of(text: str) -> dict[tuple[str, ...], list[list[str]]]:
    """The rows of the tables of a page that quote a command, by the command's words."""
    found = {}
    for command, table in TABLE.findall(text):
        found.setdefault(tuple(shlex.split(command)), []).extend(_rows(table.split("\n", 2)[2]))
    for path, command in files_of(text):
        _, *rows = csv.reader((ROOT / "docs" / path).read_text().splitlines())
        found.setdefault(tuple(shlex.split(command)), []).extend(rows)
    return found


def files_of(text: str) -> list[tuple[str, str]]:
    """The files of docs/data/ that a page links to, each with the command that prints its rows."""
    return re.findall(r"\]\((data/[\w-]+\.csv)\)<!-- table: (.*?) -->", text)


def missing_rows(quoted: list[list[str]], printed: str) -> list[list[str]]:
    """Rows that no row of the printed tables has.

    A printed row may have more cells. Numbers are equal if the printed one, rounded to as many digits, is the quoted
    one.
    """
    rows = _rows("\n".join(re.findall(r"^\|.*\|$", printed, re.MULTILINE)))
    return [row for row in quoted if not any(_has(candidate, row) for candidate in rows)]


def _rows(table):
    rows = [[cell.strip(" `") for cell in line.strip().strip("|").split("|")] for line in table.splitlines()]
    return [row for row in rows if any(re.match(r"\**-?\d", cell) for cell in row)]


def _has(candidate, row):
    left = list(candidate)
    for cell in row:
        same = next((other for other in left if _is_same(cell, other)), None)
        if same is None:
            return False
        left.remove(same)
    return True


def _is_same(quoted, printed):
    if not re.fullmatch(r"-?[\d,]+(?:\.\d+)?", quoted):
        return quoted == printed
    digits = len(quoted.partition(".")[2])
    try:
        return abs(float(printed.replace(",", "")) - float(quoted.replace(",", ""))) <= 0.5001 * 10.0 ** -digits
    except ValueError:
        return False
