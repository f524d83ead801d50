"""Errors of files that cannot be parsed."""

from pathlib import Path

from golden.base.errors import InputError

__all__ = ["check_regular", "unreadable"]


def check_regular(path: Path) -> None:
    """A path is not a pipe or a device, which a reader might wait for or read for ever; it need not exist.

    Raises
    ------
    InputError
        It is one.
    """
    if path.exists() and not path.is_file():
        raise InputError(f"{path}: it is not a regular file")


def unreadable(kind: str, reason: object) -> InputError:
    """The error of a file that is not of its ``kind``, on one line."""
    text = " ".join(str(reason).split()) or type(reason).__name__
    return InputError(f"not a readable {kind} file ({text})")
