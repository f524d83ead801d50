"""Work in spans of whole numbers: a function of a first and a last one, one span after the other or in threads.

What a span gives does not depend on the others, so the order in which spans end does not matter.

All threads that compute are made here. Work in a thread may itself be in spans: its threads are a share of those that
the outermost work was given.
"""

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from threading import local
from typing import Any

__all__ = ["Span", "Spread", "in_threads", "in_turn", "spans"]

Span = tuple[int, int]
"""The first number, and the last one plus 1."""

Spread = Callable[[Callable[[int, int], Any], Iterable[Span]], Iterator[tuple[Span, Any]]]
"""From a function and spans to each span with its result, as soon as it is there."""

# Threads that the work of this thread may use.
_share = local()


def spans(count: int, size: int) -> list[Span]:
    """The numbers 0 to ``count`` - 1 in spans of ``size``, of which the last one may be shorter."""
    return [(first, min(first + size, count)) for first in range(0, count, size)]


def in_turn(function: Callable[[int, int], Any], parts: Iterable[Span]) -> Iterator[tuple[Span, Any]]:
    """A `Spread` that computes each span when it is requested."""
    for part in parts:
        yield part, function(*part)


def in_threads(jobs: int) -> Spread:
    """A `Spread` by at most so many threads. An error ends it: spans that no thread has begun stay undone.

    In a thread of another one, as many threads as are left for it. Fewer spans than threads leave some for their work.
    """
    jobs = min(jobs, getattr(_share, "jobs", jobs))

    def spread(function, parts):
        parts = list(parts)
        count = min(jobs, len(parts))
        if count <= 1:
            yield from in_turn(function, parts)
            return
        with ThreadPoolExecutor(count, initializer=_may_use, initargs=(jobs // count,)) as threads:
            futures = {threads.submit(function, *part): part for part in parts}
            try:
                for future in as_completed(futures):
                    yield futures[future], future.result()
            finally:
                threads.shutdown(wait=False, cancel_futures=True)
    return in_turn if jobs == 1 else spread


def _may_use(jobs):
    """Let the work of this thread have so many threads."""
    _share.jobs = jobs
