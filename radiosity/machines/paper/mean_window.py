"""Mean window: the extents of the windows of patches, which size the next subshells."""

from golden.engine.icu.window import Window

__all__ = ["MeanWindow"]


class MeanWindow:
    """The paper's *Averaging Omega*: it accumulates the windows of the patches that the intersection unit sets up.

    Source: Shen & Deprettere, section 1.3.2. That the mean is the size itself, and how it is rounded, are our choice.
    """

    def __init__(self):
        self._patches = self._columns = self._rows = 0

    def add(self, window: Window) -> None:
        """Accumulate the windows of patches; those without rays do not count."""
        self._patches += int((window.rays > 0).sum())
        self._columns += int(window.column_count.sum())
        self._rows += int(window.row_count.sum())

    @property
    def extents(self) -> tuple[int, int] | None:
        """Mean columns and rows, rounded to nearest, at least 1; None before the first patch."""
        if not self._patches:
            return None
        twice = 2 * self._patches
        return tuple(max(1, (2 * total + self._patches) // twice) for total in (self._columns, self._rows))
