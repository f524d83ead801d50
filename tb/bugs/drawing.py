"""Drawn bugs: so many of each folder as it has lines, every second one in combination with something else."""

import ast
import difflib
import hashlib
import heapq
import random
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import islice
from pathlib import Path

from tb.bugs.guards import guarded, guards
from tb.bugs.rules import changes
from tb.bugs.source import FUNCTIONS, Source

__all__ = ["LEAST", "PACKAGES", "Bug", "candidates", "strata", "stratum_of"]

PACKAGES = ("golden", "hw", "radiosity")
# The share of the smallest folder.
LEAST = 0.01
# After so many a folder has no bug that counts.
_DRAWS = 1000


@dataclass(frozen=True, kw_only=True)
class Bug:
    """A bug of the sources.

    Parameters
    ----------
    number, stratum
        Which one of a draw, and the folder.
    path, line
        Where.
    rule, guard
        By which it was made, and the kind of its condition: "" if it always shows.
    condition
        The condition's text.
    text
        The file with the bug.
    diff
        Lines that it changes.
    digest
        Of the path, the rule, and its function without and with it: as long as these stay, so does the bug.
    """

    number: int
    stratum: str
    path: str
    line: int
    rule: str
    guard: str
    condition: str
    text: str
    diff: str
    digest: str

    def record(self) -> dict:
        """All but the text."""
        return {name: value for name, value in asdict(self).items() if name != "text"}


def stratum_of(path: str) -> str:
    """The folder that a file counts for: ``golden/light`` of ``golden/light/factors/join.py``."""
    return "/".join(path.split("/")[:-1][:2])


def strata(files: dict[str, int], number: int, seed: str) -> list[str]:
    """The folders of the first bugs of a draw, in proportion to their lines and with at least `LEAST` of all each.

    A longer draw begins with the shorter one.

    Parameters
    ----------
    files
        Lines by path.
    number
        Of bugs.
    seed
        Text that decides where each folder's bugs lie in the draw.
    """
    lines = {}
    for path, size in files.items():
        lines[stratum_of(path)] = lines.get(stratum_of(path), 0) + size
    shares = {name: max(size / sum(lines.values()), LEAST) for name, size in sorted(lines.items())}
    times = ([((index + random.Random(f"{seed} {name}").random()) / share, name) for index in range(number)]
             for name, share in shares.items())
    return [name for _, name in islice(heapq.merge(*times), number)]


def candidates(root: Path, files: dict[str, int], stratum: str, number: int, seed: str) -> Iterator[Bug]:
    """Bugs of a folder in the order in which they are tried: file by lines, then rule, then place, then condition.

    Parameters
    ----------
    root
        Of the sources.
    files
        Lines by path.
    stratum
        The folder.
    number
        Of the bug; odd ones have a condition.
    seed
        Of the draw.
    """
    draw = random.Random(f"{seed} {number}")
    paths = sorted(path for path in files if stratum_of(path) == stratum)
    for _ in range(_DRAWS):
        path = draw.choices(paths, [files[path] for path in paths])[0]
        source = Source(path, (root / path).read_text())
        by_rule = {}
        for change in changes(source):
            by_rule.setdefault(change.rule, []).append(change)
        if not by_rule:
            continue
        change = draw.choice(by_rule[draw.choice(sorted(by_rule))])
        guard = None
        if number % 2:
            kinds = {}
            for one in guards(source, change):
                kinds.setdefault(one.kind, []).append(one)
            if not kinds:
                continue
            guard = draw.choice(kinds[draw.choice(sorted(kinds))])
        if (made := _bug(source, change, guard, number, stratum)) is not None:
            yield made


def _bug(source, change, guard, number, stratum):
    """A bug of a change and a condition, if it changes the program and is one."""
    edit = (change.begin, change.end, change.new) if guard is None else guarded(source, change, guard)
    if edit is None:
        return None
    edits = sorted([edit, *([guard.loop] if guard is not None and guard.loop else [])], reverse=True)
    data = source.data
    for begin, end, new in edits:
        data = data[:begin] + new.encode() + data[end:]
    text = data.decode()
    try:
        tree = ast.parse(text)
    except SyntaxError:
        return None
    if ast.dump(tree) == ast.dump(source.tree):
        return None
    diff = "".join(difflib.unified_diff(source.text.splitlines(keepends=True), text.splitlines(keepends=True),
                                        source.path, source.path, n=2))
    function = next((one for one in source.around(change.node) if isinstance(one, FUNCTIONS)), None)
    begin, end = source.span(function) if function is not None else (0, len(source.data))
    grown = len(data) - len(source.data)
    about = (source.path, change.rule, source.data[begin:end].decode(), data[begin:end + grown].decode())
    return Bug(number=number, stratum=stratum, path=source.path, line=source.data[:change.begin].count(b"\n") + 1,
               rule=change.rule, guard=guard.kind if guard else "", condition=guard.condition if guard else "",
               text=text + (guard.helper if guard else ""), diff=diff,
               digest=hashlib.sha256("\0".join(about).encode()).hexdigest()[:12])
