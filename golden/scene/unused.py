"""What a file holds and its scene does not use."""

from golden.base.input_warnings import warn

__all__ = ["NORMALS", "Unused"]

NORMALS = "normals that contradict the order of corners"
"""The kind of faces whose normals in the file are opposite to that of their corners' order."""


class Unused:
    """Kinds of content that a reader skips, with their counts, named in one warning (`warn`)."""

    def __init__(self):
        self._counts: dict[str, int] = {}

    def add(self, what: str, count: int = 1) -> None:
        """Counts content of a kind; nothing if ``count`` is 0."""
        if count:
            self._counts[what] = self._counts.get(what, 0) + count

    def warn(self, where: str = "") -> None:
        """Names all that was counted in one warning, after ``where``; nothing if there is none."""
        if self._counts:
            kinds = ", ".join(what if count == 1 else f"{what} ({count})" for what, count in self._counts.items())
            warn(f"{where}{': ' if where else ''}not used: {kinds}")
