"""The error that the user can correct."""

__all__ = ["InputError"]


class InputError(Exception):
    """The user's input cannot be used: one line that names the fault and its position.

    The command line prints it as ``error: ...`` and exits with code 2; nothing is written.
    """
