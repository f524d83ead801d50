"""The one error that is the user's to mend."""

__all__ = ["InputError"]


class InputError(Exception):
    """Something the user gave cannot be used: one line that says what is wrong and where.

    The command line prints it as ``error: ...`` and exits with code 2; nothing is written.
    """
