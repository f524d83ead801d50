"""Files that are written whole or not at all."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from golden.errors import InputError

__all__ = ["check_outputs", "whole_file"]


def check_outputs(*paths: Path | None, suffixes: tuple[str, ...]) -> None:
    """Make sure that every path (None is skipped) can be written, before the work starts that fills it.

    Raises
    ------
    InputError
        A path ends in none of ``suffixes``, is a directory, or lies where no file can be made.
    """
    for path in paths:
        if path is None:
            continue
        if path.suffix.lower() not in suffixes:
            raise InputError(f"output {str(path)!r}: Name must end in {' or '.join(suffixes)}, not {path.suffix!r}")
        if os.path.isdir(path):  # unlike the method, says no where the system cannot say
            raise InputError(f"output {str(path)!r}: it is a directory")
        part = _part(path)
        try:
            part.touch(exist_ok=True)
            part.unlink()
        except OSError as error:
            raise InputError(f"output {str(path)!r}: cannot be written ({error.strerror})") from error


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """The name of a neighbour of ``path`` to write; it takes the place of ``path`` if the block ends well.

    Whatever goes wrong, ``path`` holds what it held before or the new content, never a part of it.

    Raises
    ------
    OSError
        The system refuses to rename or write.
    """
    part = _part(path)
    try:
        yield part
        part.replace(path.resolve())
    finally:
        part.unlink(missing_ok=True)


def _part(path: Path) -> Path:
    # The suffix stays last: writers choose their format by it.
    path = path.resolve()
    return path.with_name(f".{path.stem}.part{os.getpid()}{path.suffix}")
