"""A page of what killed the bugs of a draw."""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

__all__ = ["EQUIVALENT", "page", "read_equivalent"]

EQUIVALENT = Path(__file__).parent / "equivalent.txt"
_KILLS = {"near": "near", "folder": "folder", "simulators": "folder", "commit": "commit",
          "detectors": "change detector"}
_COLUMNS = ("near", "folder", "commit", "change detector", "survived", "equivalent")


def read_equivalent(text: str) -> dict[str, str]:
    """By digest of a bug why nothing can tell it from the program; lines with ``#`` in front are comments.

    Raises
    ------
    ValueError
        A line has no reason, or a digest is there twice.
    """
    found = {}
    for line in text.splitlines():
        if not line.strip() or line.startswith("#"):
            continue
        digest, _, reason = line.partition(" ")
        if not reason.strip() or digest in found:
            raise ValueError(f"Lines of equivalent bugs must be a digest and a reason, each once, not {line!r}")
        found[digest] = reason.strip()
    return found


def _end(result, equivalent):
    if "killer" in result:
        return _KILLS[result["stage"]]
    return "equivalent" if result["digest"] in equivalent else "survived"


def _row(name, chosen, equivalent):
    """A row of counts; the share is that of bugs killed by behaviour of those that are not equivalent."""
    ends = [_end(result, equivalent) for result in chosen]
    counts = [ends.count(column) for column in _COLUMNS]
    killed, total = sum(counts[:3]), len(ends) - counts[-1]
    seconds = sum(sum(result["seconds"].values()) for result in chosen)
    share = f"{killed / total:.0%}" if total else ""
    return [name, len(ends), *counts, share, f"{seconds / killed:.0f}" if killed else f"({seconds:.0f})"]


def _groups(results, key: Callable, equivalent) -> Iterable[list]:
    for name in sorted({key(result) for result in results}):
        yield _row(name, [result for result in results if key(result) == name], equivalent)


def _table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(map(str, line))} |" for line in lines) + "\n"


def page(results: Mapping[int, dict], equivalent: Mapping[str, str]) -> str:
    """Counts by folder, rule and condition; the killer of each bug; survivors with their lines.

    Parameters
    ----------
    results
        By number: a bug's record, ``seconds`` by stage, stages that were ``limited``, and if it was killed ``killer``
        and ``stage``.
    equivalent
        Reasons by digest.
    """
    done = [results[number] for number in sorted(results)]
    columns = ["bugs", *_COLUMNS, "killed", "CPU s a kill"]
    parts = [_table([title, *columns], [*_groups(done, key, equivalent)]) for title, key in (
        ("folder", lambda one: one["stratum"]), ("rule", lambda one: one["rule"]),
        ("condition", lambda one: one["guard"] or "none"))]
    parts.append(_table(["", *columns], [
        _row("alone", [one for one in done if not one["guard"]], equivalent),
        _row("in combination", [one for one in done if one["guard"]], equivalent), _row("all", done, equivalent)]))
    parts.append(_table(["bug", "at", "rule", "condition", "first killer", "CPU s"], [
        [number, f"{one['path']}:{one['line']}", one["rule"], one["guard"], one.get("killer", _end(one, equivalent)),
         f"{sum(one['seconds'].values()):.0f}"] for number, one in sorted(results.items())]))
    for number, one in sorted(results.items()):
        if _end(one, equivalent) in ("survived", "change detector"):
            limited = f", more than the time of {' and '.join(one['limited'])}" if one["limited"] else ""
            parts.append(f"Bug {number}, digest {one['digest']}, {_end(one, equivalent)}{limited}:\n\n"
                         f"```diff\n{one['diff']}```\n")
    return "\n".join(parts)
