"""A table of coverage: the arms of each block that a run entered, and those that it did not."""

from collections import Counter
from collections.abc import Iterable

__all__ = ["missing", "table"]


def table(elaborated: Iterable[str], entered: Iterable[str], excluded: Iterable[str]) -> str:
    """Markdown with a row for each folder of ``hw``, and all.

    Parameters
    ----------
    elaborated, entered
        Arms, see `tb.coverage.arms`.
    excluded
        Arms that need not be entered; of these only what was not counts as excluded.
    """
    entered, left = set(entered), set(excluded)
    counts: dict[str, Counter] = {}
    for arm in elaborated:
        for folder in (arm.rpartition("/")[0], "all"):
            count = counts.setdefault(folder, Counter())
            count.update(arms=1, entered=int(arm in entered), excluded=int(arm in left - entered))
    last = counts.pop("all", Counter())
    return "\n".join(["| folder | arms | entered | excluded | % |", "|---|---|---|---|---|", *(
        f"| {f'`{name}`' if name != 'all' else name} | {one['arms']} | {one['entered']} | {one['excluded']} | "
        f"{100 * one['entered'] / max(1, one['arms'] - one['excluded']):.1f} |"
        for name, one in [*sorted(counts.items()), ("all", last)])])


def missing(elaborated: Iterable[str], entered: Iterable[str], excluded: Iterable[str]) -> list[str]:
    """Arms that were neither entered nor excluded, in order of files and lines."""
    def place(arm):
        path, *lines = arm.split(":")
        return path, *map(int, lines)

    return sorted(set(elaborated) - set(entered) - set(excluded), key=place)
