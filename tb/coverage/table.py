"""A table of coverage: the arms and toggles of each block that a run has covered, and what it has not."""

import re
from collections import Counter
from collections.abc import Iterable, Mapping

__all__ = ["missing", "needless", "table"]


def table(run: Mapping, excluded: Iterable[str]) -> str:
    """Markdown with a row for each folder of ``hw``, and all.

    Parameters
    ----------
    run
        What `tb.coverage.plugin` writes: of ``arms`` and ``toggles`` those ``elaborated`` and those ``covered``.
    excluded
        Arms, signals and bits that need not be covered; of these only what was not counts as excluded.
    """
    excluded = set(excluded)
    kinds = {kind: _counts(one, excluded) for kind, one in run.items()}
    folders = sorted({name for counts in kinds.values() for name in counts} - {"all"})
    head = " | ".join(f"{kind} | excluded | covered" for kind in kinds)
    return "\n".join([f"| folder | {head} |", "|---" * (1 + 3 * len(kinds)) + "|", *(
        f"| {f'`{name}`' if name != 'all' else name} | " + " | ".join(
            _cells(counts.get(name, Counter())) for counts in kinds.values()) + " |" for name in (*folders, "all"))])


def _counts(one, excluded):
    """By folder, and of all: how many there are, are covered, and are excluded."""
    covered, counts = set(one["covered"]), {}
    for point in one["elaborated"]:
        for folder in (point.split(":")[0].rpartition("/")[0], "all"):
            counts.setdefault(folder, Counter()).update(
                all=1, covered=int(point in covered),
                excluded=int(point not in covered and not excluded.isdisjoint(_names(point))))
    return counts


def _cells(count):
    left = count["all"] - count["excluded"]
    return f"{count['all']} | {count['excluded']} | " + (f"{100 * count['covered'] / left:.1f} %" if left else "-")


def _names(point):
    """The names by which a point can be excluded: itself, and of a toggle its bit and its signal."""
    return {point, point[:-1], re.sub(r"\[\d+\][+-]$", "", point)}


def missing(run: Mapping, excluded: Iterable[str]) -> list[str]:
    """Arms, and signals with their bits, that were neither covered nor excluded, in order of files and lines."""
    excluded = set(excluded)
    left = [point for one in run.values() for point in set(one["elaborated"]) - set(one["covered"])
            if excluded.isdisjoint(_names(point))]
    signals: dict[str, list[str]] = {}
    for point in sorted(left, key=_natural):
        name, bit, sign = re.fullmatch(r"(.*?)(?:\[(\d+)\]([+-]))?", point).groups()
        signals.setdefault(name, []).extend([] if bit is None else [f"{bit}{sign}"])
    return [" ".join([name, *bits]) for name, bits in signals.items()]


def _natural(point):
    """Numbers in a name are compared as numbers."""
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", point)]


def needless(run: Mapping, excluded: Iterable[str]) -> list[str]:
    """What is excluded though the run has covered it, or though nothing in its file has that name."""
    files = {point.split(":")[0] for one in run.values() for point in one["elaborated"]}
    left = {name for one in run.values() for point in set(one["elaborated"]) - set(one["covered"])
            for name in _names(point)}
    return sorted(name for name in set(excluded) - left if name.split(":")[0] in files)
