"""The error that the user can correct, and checks of types."""

from numbers import Integral

__all__ = ["InputError", "InputWarning", "check_int"]


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


def check_int(name: str, value: object) -> None:
    """``value`` is a whole number; bool is none.

    Raises
    ------
    TypeError
        It is not.
    """
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise TypeError(f"{name} must be an int, not {value!r}")
