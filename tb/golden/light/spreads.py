"""Executors of spans that end in the least convenient order."""

from collections.abc import Callable, Iterable, Iterator
from typing import Any

from golden.base.spread import Span

__all__ = ["backwards"]


def backwards(function: Callable[[int, int], Any], parts: Iterable[Span]) -> Iterator[tuple[Span, Any]]:
    """A `golden.base.spread.Spread` of which the last span ends first; the second one ends last, and not the first."""
    first, *others = parts
    for part in [*others[1:][::-1], first, *others[:1]]:
        yield part, function(*part)
