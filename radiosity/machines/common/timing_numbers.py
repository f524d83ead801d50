"""Timing numbers: fields of a simulated timing, which are integers, and none below its least."""

from dataclasses import fields
from typing import ClassVar

from golden.base.errors import check_int

__all__ = ["PositiveNumbers", "TimingNumbers"]


class TimingNumbers:
    """A base of dataclasses whose fields are all integers of at least 0, or of at least 1 if ``POSITIVE`` names them.

    Raises
    ------
    TypeError
        A number is no int.
    ValueError
        A number is below its least.
    """

    POSITIVE: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self):
        for field in fields(self):
            value, name = getattr(self, field.name), field.name.replace("_", "-").capitalize()
            check_int(name, value, least=self._least(field.name))

    def _least(self, name):
        return int(name in self.POSITIVE)


class PositiveNumbers(TimingNumbers):
    """`TimingNumbers` of which each is at least 1."""

    def _least(self, name):
        return 1
