"""Columns: names for the columns of arrays that compiled functions change."""

from collections import namedtuple
from collections.abc import Iterable

__all__ = ["columns"]


def columns(name: str, names: str, numbers: Iterable[int] | None = None) -> tuple:
    """A tuple of the numbers of columns, which has them by name too.

    Compiled code has them as constants, and Python reads them as fast as attributes of a module, unlike the members of
    an enumeration.

    Parameters
    ----------
    name
        What a row is of.
    names
        Of the columns, in their order.
    numbers
        Of the columns. Default: one after the other, from 0 on.
    """
    kind = namedtuple(name, names)
    return kind(*(range(len(kind._fields)) if numbers is None else numbers))
