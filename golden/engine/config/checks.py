"""Checks of parameters: messages name the parameter in words and by path."""

from golden.base.errors import InputError, check_int

__all__ = ["check_choice", "check_power_of_two", "check_range"]


def check_range(group: str, name: str, value: object, low: int, high: int):
    """The parameter ``group``.``name`` is a whole number from ``low`` to ``high``.

    Raises
    ------
    TypeError
        It is no whole number.
    InputError
        It is out of range.
    """
    check_int(_label(group, name), value)
    if not low <= value <= high:
        raise InputError(_message(group, name, f"{low} to {high}", value))


def check_power_of_two(group: str, name: str, value: object, low: int, high: int, *, or_zero: bool = False):
    """The parameter ``group``.``name`` is a power of two from ``low`` to ``high``, or 0 if that may be.

    Raises
    ------
    TypeError
        It is no whole number.
    InputError
        It is out of range, or no power of two.
    """
    check_int(_label(group, name), value)
    either = "0, or " if or_zero else ""
    if not (low <= value <= high or (or_zero and value == 0)):
        raise InputError(_message(group, name, f"{either}{low} to {high}", value))
    if value & (value - 1):
        raise InputError(_message(group, name, f"{either}a power of two", value))


def check_choice(group: str, name: str, value: object, choices: tuple[str, ...]):
    """The parameter ``group``.``name`` is one of ``choices``.

    Raises
    ------
    InputError
        It is not.
    """
    if value not in choices:
        raise InputError(_message(group, name, ", ".join(choices), value))


def _label(group, name):
    return f"configuration: {name.replace('_', ' ').capitalize()} ({group}.{name})"


def _message(group, name, requirement, value):
    return f"{_label(group, name)} must be {requirement}, not {value!r}"
