"""Functional coverage: cases that a test must reach."""

from collections.abc import Iterable

import numpy as np

__all__ = ["Coverage"]


class Coverage:
    """Counts how often each named case occurred; a case that never occurred is an error.

    The stimulus, golden, or the transfers of a component's streams decide whether a case occurred, never a signal of
    the component under test alone: a fault could hide the case that shows it.

    Parameters
    ----------
    cases
        Their names.

    Members
    -------
    counts
        By name.

    Raises
    ------
    ValueError
        There are no cases, or two of one name.
    """

    def __init__(self, cases: Iterable[str]):
        names = list(cases)
        if not names or len(set(names)) != len(names):
            raise ValueError(f"Cases must be at least one, each with a name of its own, not {names!r}")
        self.counts = dict.fromkeys(names, 0)

    def hit(self, name: str, where=True) -> None:
        """A case occurred: once, or as often as an array is true.

        Raises
        ------
        KeyError
            There is no such case.
        """
        if name not in self.counts:
            raise KeyError(f"there is no case {name!r}; there are {', '.join(self.counts)}")
        self.counts[name] += int(np.count_nonzero(where))

    def hit_all(self, cases: dict) -> None:
        """`hit` for each name and what it holds for."""
        for name, where in cases.items():
            self.hit(name, where)

    def has(self, names: Iterable[str]) -> bool:
        """Whether all of these cases have occurred."""
        return all(self.counts[name] for name in names)

    @property
    def missing(self) -> list[str]:
        """Cases that have not occurred."""
        return [name for name, count in self.counts.items() if not count]

    def check(self) -> None:
        """All cases have occurred.

        Raises
        ------
        AssertionError
            Names those that have not.
        """
        missing = self.missing
        assert not missing, f"{len(missing)} of {len(self.counts)} cases never occurred: {', '.join(missing)}"
