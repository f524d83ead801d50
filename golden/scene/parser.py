"""Third-party parsers of files: their errors become the user's."""

import io

import trimesh

from golden.errors import InputError

__all__ = ["load_with_trimesh", "unreadable"]


def unreadable(kind: str, reason: object) -> InputError:
    """The error of a file that is not of its ``kind``, on one line."""
    text = " ".join(str(reason).split()) or type(reason).__name__
    return InputError(f"not a readable {kind} file ({text})")


def load_with_trimesh(data: bytes, kind: str, *, resolver=None) -> trimesh.Scene:
    """The meshes of a file's content.

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
    try:
        return trimesh.load_scene(io.BytesIO(data), file_type=kind, process=False, resolver=resolver)
    except (OSError, MemoryError):
        raise
    except Exception as error:  # trimesh raises errors of any type for bad content
        raise unreadable(kind.upper(), error) from error
