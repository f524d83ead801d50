"""Files that are written atomically."""

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from golden.base.errors import InputError

__all__ = ["beginning_with", "check_inputs_stay", "check_named_once", "check_outputs", "check_text_name", "whole_file"]


def check_outputs(*paths: Path | None, suffixes: tuple[str, ...]) -> None:
    """Every path can be written (None is skipped); to be checked before the work starts.

    Raises
    ------
    InputError
        A path ends in none of ``suffixes``, is a directory, or no file can be made there.
    """
    for path in paths:
        if path is None:
            continue
        if path.suffix.lower() not in suffixes:
            raise InputError(f"output {str(path)!r}: Name must end in {' or '.join(suffixes)}, not {path.suffix!r}")
        if os.path.isdir(path):  # unlike Path.is_dir, it is False for paths that the system refuses
            raise InputError(f"output {str(path)!r}: it is a directory")
        part = _part(path)
        try:
            part.touch(exist_ok=True)
            part.unlink()
        except OSError as error:
            raise InputError(f"output {str(path)!r}: cannot be written ({error.strerror})") from error


def check_text_name(path: Path) -> None:
    """The name of a path can stand in another file, as UTF-8.

    Raises
    ------
    InputError
        It is not UTF-8.
    """
    try:
        path.name.encode()
    except UnicodeEncodeError:
        raise InputError(f"output {str(path)!r}: Name must be UTF-8, which another file holds, not {path.name!r}"
                         ) from None


def check_named_once(*paths: Path | None) -> None:
    """No two outputs are the same path (None is skipped).

    Raises
    ------
    InputError
        Two are.
    """
    resolved = [path.resolve() for path in paths if path is not None]
    for path in paths:
        if path is not None and resolved.count(path.resolve()) > 1:
            raise InputError(f"output {str(path)!r}: it is named twice")


def beginning_with(prefix: Path | None, *endings: str) -> tuple[Path, ...]:
    """The paths of several files whose names begin with that of ``prefix``; none if it is None.

    Raises
    ------
    InputError
        The prefix has no name.
    """
    if prefix is None:
        return ()
    if not prefix.name:
        raise InputError(f"output {str(prefix)!r}: Prefix must have a name, not be a folder")
    return tuple(prefix.with_name(prefix.name + ending) for ending in endings)


def check_inputs_stay(*inputs: str | Path, outputs: Iterable[Path | None]) -> None:
    """No output is the file of an input, by another name or a link either; inputs that are no files are skipped.

    Raises
    ------
    InputError
        One is.
    """
    for output in outputs:
        for source in inputs:
            is_same = False
            with suppress(OSError, ValueError):  # one of them does not exist
                is_same = output is not None and os.path.samefile(source, output)
            if is_same:
                raise InputError(f"output {str(output)!r}: it is the input")


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A temporary path beside ``path`` to write, with its suffix in lower case; it replaces ``path`` if the block
    succeeds.

    After an error ``path`` has its old content; it never has a part of the new content.

    Raises
    ------
    OSError
        The system refuses to rename or write; the error names ``path``.
    """
    part = _part(path)
    try:
        yield part
        part.replace(path.resolve())
    except OSError as error:
        if error.filename not in (None, str(part)):  # a full disk is reported without a name
            raise
        raise OSError(error.errno, error.strerror, str(path)) from error
    finally:
        with suppress(OSError):  # there may be no such folder; the first error matters
            part.unlink(missing_ok=True)


def _part(path: Path) -> Path:
    # The suffix stays last, that of a link too: writers select their format by it.
    resolved = path.resolve()
    return resolved.with_name(f".{resolved.stem}.part{os.getpid()}{path.suffix.lower()}")
