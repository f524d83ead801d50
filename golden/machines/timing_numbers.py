"""Numbers of a timing: whole ones, and none below its least."""

from collections.abc import Collection
from dataclasses import fields

from golden.errors import check_int

__all__ = ["check_numbers"]


def check_numbers(timing: object, *, positive: Collection[str]) -> None:
    """All fields of a dataclass are whole numbers of at least 0, those in ``positive`` of at least 1.

    Raises
    ------
    TypeError
        A number is no int.
    ValueError
        A number is below its least.
    """
    for field in fields(timing):
        value, name = getattr(timing, field.name), field.name.replace("_", "-").capitalize()
        check_int(name, value)
        least = int(field.name in positive)
        if value < least:
            raise ValueError(f"{name} must be at least {least}, not {value!r}")
