"""Warnings on the user's input, caught by the thread that gives them."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from golden.base.errors import InputWarning

__all__ = ["caught_warnings", "warn"]

_caught: ContextVar[list[str] | None] = ContextVar("caught", default=None)


def warn(message: str) -> None:
    """Warn by an `InputWarning`, or add the message, one line, to those that this thread catches.

    The warning is about the caller of the function that calls this one.
    """
    caught = _caught.get()
    if caught is None:
        warnings.warn(message, InputWarning, stacklevel=3)
    else:
        caught.append(message)


@contextmanager
def caught_warnings() -> Iterator[list[str]]:
    """Catch what this thread warns of in the block.

    `warnings.catch_warnings` replaces the filters of the whole process: beside other threads it loses their warnings
    and may leave its own filters behind.
    """
    caught = []
    token = _caught.set(caught)
    try:
        yield caught
    finally:
        _caught.reset(token)
