"""Progress bars that also show where the terminal does not know its size."""

import os
import sys

from tqdm import tqdm

__all__ = ["progress_bar"]

# The size of a terminal that reports none, as some serial lines and containers do.
_USUAL = {"ncols": 80, "nrows": 24}


def progress_bar(*arguments, **options) -> tqdm:
    """A `tqdm.tqdm` on stderr; it takes the same parameters."""
    return tqdm(*arguments, **(_USUAL if _size_is_unknown() else {}), **options)


def _size_is_unknown() -> bool:
    """Whether stderr is a terminal without columns or without rows."""
    try:
        return 0 in os.get_terminal_size(sys.stderr.fileno())
    except (OSError, ValueError):  # stderr is no terminal, or no file
        return False
