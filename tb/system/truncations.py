"""Where a component loses bits without saying so."""

import sys
from contextlib import contextmanager
from pathlib import Path

import pytest
from amaranth.hdl import Const, Fragment, Signal, Value
from amaranth.lib import wiring

from golden.base.without_collection import without_collection

__all__ = ["truncations"]

_ROOT = Path(__file__).parents[2]
_SOURCES = _ROOT / "hw"


def truncations(*components: wiring.Component) -> dict[str, set[str]]:
    """Of each file of the project what it says that cannot be meant, once components are elaborated.

    Said of a signal, or of a part of one: it is assigned to something narrower, and no slice says which bits are meant.
    An operation's result may be longer than what it is assigned to: a counter wraps. Said of a comparison: the number
    has more bits than what it is compared with.
    """
    found: dict[str, set[str]] = {}
    with _watched(found), without_collection():
        for component in components:
            Fragment.get(component, None)
    return found


@contextmanager
def _watched(found):
    def note(text):
        frame = sys._getframe(2)
        while not (path := Path(frame.f_code.co_filename)).is_relative_to(_SOURCES):
            frame = frame.f_back
        found.setdefault(path.relative_to(_ROOT).as_posix(), set()).add(f"line {frame.f_lineno}: {text}")

    assign, compare = Value.eq, Value.__eq__

    def eq(self, value, *, src_loc_at=0):
        given = Value.cast(value)
        if len(given) > len(self) > 0 and _is_plain(given):
            note(f"{len(self)} of {len(given)} bits of {given!r}")
        return assign(self, value, src_loc_at=src_loc_at + 1)

    def equals(self, other):
        if isinstance(other, int) and not self.shape().signed and other >> len(self):
            note(f"{other} is compared with {len(self)} bits")
        return compare(self, other)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Value, "eq", eq)
        patch.setattr(Value, "__eq__", equals)
        yield


def _is_plain(value):
    """Whether a value is a signal, a part of one, or a number that is not all ones."""
    return isinstance(value, Signal) or type(value).__name__ in ("Slice", "Part", "ArrayProxy") or (
        isinstance(value, Const) and value.value > 0)
