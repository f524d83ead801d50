"""Third-party parsers of files: their errors become the user's."""

import io
from pathlib import Path

from golden.errors import InputError

__all__ = ["check_regular", "load_with_trimesh", "unreadable"]


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


def load_with_trimesh(data: bytes, kind: str, *, resolver=None):
    """The meshes of a file's content, a `trimesh.Scene`.

    Parameters
    ----------
    data
        Content of the file.
    kind
        Suffix of the format, for example ``stl``.
    resolver
        trimesh's resolver of further files.

    Raises
    ------
    InputError
        trimesh cannot parse the content.
    OSError
        A further file cannot be read.
    """
    import trimesh  # slow

    try:
        return trimesh.load_scene(io.BytesIO(data), file_type=kind, process=False, resolver=resolver)
    except (OSError, MemoryError):
        raise
    except Exception as error:  # trimesh raises errors of any type for bad content
        raise unreadable(kind.upper(), error) from error
