"""The error that the user can correct, and checks of types."""

from collections.abc import Collection
from numbers import Integral

__all__ = ["InputError", "InputWarning", "check_choice", "check_int"]


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
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise TypeError(f"{name} must be an int, not {value!r}")
    if least is not None and value < least:
        raise InputError(f"{name} must be at least {least}, not {value!r}")
