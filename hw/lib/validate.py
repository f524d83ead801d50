"""Checks of constructor arguments: one form of message for all components."""

__all__ = ["check_instance", "check_integer", "check_power_of_two"]


def check_integer(name: str, value, *, minimum: int | None = None, maximum: int | None = None) -> None:
    """An argument is an integer of a range.

    Parameters
    ----------
    name
        Of the argument, as it begins a sentence.
    value
        What was given.
    minimum, maximum
        Bounds, both inclusive.

    Raises
    ------
    TypeError
        The value is no integer (a Boolean is none).
    ValueError
        The value is out of range.
    """
    bounds = {(False, False): "an integer", (True, False): f"at least {minimum}", (False, True): f"at most {maximum}",
              (True, True): f"from {minimum} to {maximum}"}[minimum is not None, maximum is not None]
    message = f"{name} must be {bounds}, not {value!r}"
    if not isinstance(value, int) or isinstance(value, bool):
        raise TypeError(message)
    if (minimum is not None and value < minimum) or (maximum is not None and value > maximum):
        raise ValueError(message)


def check_power_of_two(name: str, value, *, minimum: int = 1, maximum: int | None = None) -> None:
    """An argument is a power of two of a range; parameters and exceptions as of `check_integer`."""
    bounds = f"at least {minimum}" if maximum is None else f"from {minimum} to {maximum}"
    message = f"{name} must be a power of two, {bounds}, not {value!r}"
    if not isinstance(value, int) or isinstance(value, bool):
        raise TypeError(message)
    if value < minimum or (maximum is not None and value > maximum) or value & value - 1:
        raise ValueError(message)


def check_instance(name: str, value, kind: type) -> None:
    """An argument is an instance of a class.

    Raises
    ------
    TypeError
        It is not.
    """
    if not isinstance(value, kind):
        article = "an" if kind.__name__[0] in "AEIOU" else "a"
        raise TypeError(f"{name} must be {article} {kind.__name__}, not {value!r}")
