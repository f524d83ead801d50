"""The error that the user can correct, and checks of types."""

from collections.abc import Collection, Iterable
from numbers import Integral
from typing import TypeGuard

__all__ = ["InputError", "InputWarning", "check_choice", "check_int", "is_whole", "whole_number", "whole_pair"]


class InputError(ValueError):
    """The user's input cannot be used: one line that names the fault and its position.

    The command line prints it as ``error: ...`` and exits with code 2; nothing is written.

    Parameters
    ----------
    message
        The line: ``Name must be RANGE, not VALUE``, behind the subject in lower case and a colon if there is one.
    parameter
        The argument at fault, by its name or in words, or None. The command line prints its option instead.
    """

    def __init__(self, message: str, *, parameter: str | None = None):
        super().__init__(message)
        self.parameter = parameter and parameter.lower().replace(" ", "_")


class InputWarning(UserWarning):
    """The user's input was not used as a whole: one line that names what is left out, or what becomes inexact.

    The command line prints it as ``warning: ...``; with ``--strict`` it is an `InputError`.
    """


def check_choice(name: str, value: object, known: Collection[str], *, parameter: str | None = None) -> None:
    """``value`` is one of the names that are known.

    Raises
    ------
    InputError
        It is not, see there for ``parameter``; ``name`` has the subject before it.
    """
    if value not in known:
        raise InputError(f"{name} must be one of {', '.join(known)}, not {value!r}", parameter=parameter)


def check_int(name: str, value: object, *, least: int | None = None) -> None:
    """``value`` is a whole number, not below ``least``; bool is none.

    Raises
    ------
    TypeError
        It is no whole number.
    InputError
        It is below ``least``.
    """
    if not is_whole(value):
        raise TypeError(f"{name} must be an int, not {value!r}")
    if least is not None and value < least:
        raise InputError(f"{name} must be at least {least}, not {value!r}")


def whole_number(name: str, value: object, low: int, high: int, *, parameter: str) -> int:
    """A user's whole number from ``low`` to ``high`` as int, of numpy's numbers too; bool is none.

    Raises
    ------
    InputError
        It is none, see there for ``parameter``; ``name`` has the subject before it.
    """
    if not is_whole(value) or not low <= value <= high:
        raise InputError(f"{name} must be {low} to {high}, not {value!r}", parameter=parameter)
    return int(value)


def whole_pair(name: str, value: object, *, parameter: str) -> tuple[int, int]:
    """A user's two whole numbers as ints, of any sequence or array.

    Raises
    ------
    InputError
        As of `whole_number`.
    """
    numbers = tuple(value) if isinstance(value, Iterable) else ()
    if len(numbers) != 2 or not all(map(is_whole, numbers)):
        raise InputError(f"{name} must be two whole numbers, not {value!r}", parameter=parameter)
    return int(numbers[0]), int(numbers[1])


def is_whole(value: object) -> TypeGuard[int]:
    """Whether it is a whole number, of numpy's too; bool is none."""
    return isinstance(value, Integral) and not isinstance(value, bool)
