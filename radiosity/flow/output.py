"""Text files that are written whole or not at all."""

from pathlib import Path

from golden.base.output import whole_file

__all__ = ["write_text"]


def write_text(path: Path, text: str) -> None:
    """Replace the content of a file; after a failure it has the content that it had before."""
    with whole_file(path) as part:
        part.write_text(text)
